//! Processor in the loop as a demonstration: builds the firmware, starts it on the emulated Cortex-M4F, and simulates its machine for a few moves.
//!
//! `cargo run --release -p system-tests --example in_the_loop`

#[cfg(unix)]
fn main() {
    use firmware::app::press;
    use firmware::set_point::{Bounds, Leg};
    use system_tests::emulator::Processor;
    use system_tests::in_the_loop::{Board, Follows, SETTLING, rig};
    use system_tests::rig::{Controller, Readings, TICK, Wanted, course, rms_mm, worst_mm};

    /// Prints its readings twice a second.
    struct Told {
        follows: Follows,
        periods: usize,
    }

    impl Controller for Told {
        fn command_v(&mut self, wanted: Wanted, seen: &Readings) -> f64 {
            let command_v = self.follows.command_v(wanted, seen);
            if self.periods.is_multiple_of(500) {
                let time_s = self.periods as f64 * TICK.seconds();
                let mode = if self.periods < SETTLING { "starting" } else { "following" };
                let [wanted_mm, seen_mm] = [wanted.position_m, seen.position_m].map(|position_m| 1e3 * position_m);
                let [a_bar, b_bar] = [seen.pressure_a_pa, seen.pressure_b_pa].map(|pressure_pa| 1e-5 * pressure_pa);
                println!(
                    "{time_s:>6.1} {mode:<10} {wanted_mm:>10.2} {seen_mm:>10.2} {command_v:>8.2} {a_bar:>6.1} {b_bar:>6.1}"
                );
            }
            self.periods += 1;
            command_v
        }
    }

    if !Processor::M4F.can_be_emulated() {
        return;
    }
    println!("building the firmware, and starting it on the emulated Cortex-M4F (mps2-an386)");
    let machine = press::machine();
    let bounds = Bounds { from_m: 0.01, to_m: 0.29, velocity_m_per_s: 0.03, acceleration_m_per_s2: 0.3 };
    let legs = [
        Leg::Rest { duration_s: 0.2 + SETTLING as f64 * TICK.seconds() },
        Leg::Fastest { to_m: 0.15 },
        Leg::Rest { duration_s: 0.5 },
        Leg::Smooth { to_m: 0.11, duration_s: 2.6 },
        Leg::Rest { duration_s: 0.5 },
    ];
    let rig = rig(&machine, course(&machine, &bounds, 0.1, &legs));
    let board = Board::start(Processor::M4F, &Processor::M4F.built("loop", None), &rig.at_rest());
    println!("time s mode        wanted mm     rod mm  valve V  A bar  B bar");
    let mut told = Told { follows: Follows::on(board), periods: 0 };
    let rows = rig.run(&mut told);
    println!("distance to the set point: {:.3} mm RMS, {:.3} mm at most", rms_mm(&rows), worst_mm(&rows));
    print!("the firmware's console:\n{}", told.follows.end().console);
}

#[cfg(not(unix))]
fn main() {
    eprintln!("the emulator's line is a Unix socket");
}
