//! Linear models beside the machine's, and what shows that the structure is wrong.

use diagnosis::Diagnosis;
use diagnosis::structure::{Measured, Shows, SupplySag, Uncommanded};
use recording::display_unit::{difference, percent, significant};
use recording::{Signal, Unit};
use simulation::InputPoint;

/// How well linear models of second order follow the recordings; `None` where there are none.
#[must_use]
pub fn yardstick(diagnosis: &Diagnosis) -> Option<String> {
    let each = |measured: &Measured| {
        let held_out = measured.held_out_percent.map(|fit| format!(" (held out {} %)", percent(fit)));
        let held_out = held_out.unwrap_or_default();
        format!("{} {} %{held_out}", measured.yardstick.signal, percent(measured.training_percent))
    };
    let measured = &diagnosis.structure.measured;
    (!measured.is_empty()).then(|| {
        let all = measured.iter().map(each).collect::<Vec<_>>().join(", ");
        format!("linear model, 2nd order, free run: {all}")
    })
}

/// That the structure is wrong, for the first sentence of a diagnosis that explains nothing; `None` where nothing shows it.
#[must_use]
pub fn structure(diagnosis: &Diagnosis) -> Option<String> {
    let found = &diagnosis.structure;
    let input = input(diagnosis);
    let told = found.shows.first().map(|shows| match shows {
        Shows::Follows { .. } => format!(
            "the structure is wrong: position follows {input} instead of integrating it; what is recorded does not look like a {}",
            drive(diagnosis)
        ),
        Shows::MovesUncommanded(moves) => {
            let does = if moves.only_retracts { "retracts" } else { "moves" };
            format!("the structure is wrong: the rod {does} where no command asks for it; is a command missing?")
        }
        Shows::SupplySags(_) => {
            "the supply pressure falls while the command is at neutral; does another consumer share the pump?".to_owned()
        }
    });
    told.or_else(|| {
        let below = found.below()?;
        let signal = below.yardstick.signal;
        Some(format!(
            "a linear model of second order follows {signal} better than this machine can; its structure may be wrong"
        ))
    })
}

/// What shows a wrong structure, a sentence each; empty where the machine's model does not end below a linear one and nothing else shows it.
#[must_use]
pub fn structure_shown(diagnosis: &Diagnosis) -> Vec<String> {
    let found = &diagnosis.structure;
    let below = found.below().map(|measured| better(diagnosis, measured));
    let shown = found.shows.iter().map(|shows| shown(diagnosis, shows));
    let nothing = (found.below().is_some() && found.shows.is_empty()).then(|| possible(diagnosis));
    below.into_iter().chain(shown).chain(nothing).collect()
}

/// What one thing shows.
#[must_use]
pub fn shown(diagnosis: &Diagnosis, shows: &Shows) -> String {
    match shows {
        Shows::Follows { gain, settling_s, follows_percent, integrates_percent } => {
            follows(diagnosis, *gain, *settling_s, *follows_percent, *integrates_percent)
        }
        Shows::MovesUncommanded(moves) => moves_uncommanded(moves),
        Shows::SupplySags(sag) => supply_sags(sag),
    }
}

/// That a linear model does better.
fn better(diagnosis: &Diagnosis, measured: &Measured) -> String {
    let signal = measured.yardstick.signal;
    let held_out = measured.held_out_percent.is_some();
    let of_machine = diagnosis.mean_fits(held_out, true).get(signal.name()).copied();
    let against = of_machine.map_or_else(String::new, |fit| format!(" against {} %", percent(fit)));
    let linear = measured.held_out_percent.unwrap_or(measured.training_percent);
    let which = if held_out { "held-out" } else { "training" };
    format!(
        "a linear model of second order follows {signal} better than the machine's model does: {} %{against} of the {which} recordings",
        percent(linear)
    )
}

fn follows(diagnosis: &Diagnosis, gain: f64, settling_s: f64, follows: f64, integrates: f64) -> String {
    let input_point = diagnosis.structure.driven_by;
    let unit = input_point.map_or("1", |point| Unit::symbol(point.driving().si_unit()));
    let input = input(diagnosis);
    let ask = match input_point {
        Some(InputPoint::Command) => {
            "is it the set value of a position control, and the valve's own command is not recorded? Is it a drive with a valve at all?"
        }
        Some(InputPoint::Force) => "does a spring hold what the force moves?",
        _ => "does something lead the position back, as a control or a spring does?",
    };
    let goes_on = match input_point {
        Some(InputPoint::Force) => "a free mass under a constant force would go on",
        Some(InputPoint::Pump | InputPoint::Flow) => "a rod moved by a flow would go on as long as it flows",
        _ => "a rod moved by a valve would go on as long as the valve is open",
    };
    format!(
        "position comes to rest at a place of its own for every value of {input}, {} further for each {unit}, after about {} s; {goes_on}. \
         Of all recordings a linear model that follows {input} reaches {} %, one that integrates it {} %: {ask}",
        difference(Signal::Position, gain),
        significant(settling_s, 2),
        percent(follows),
        percent(integrates)
    )
}

fn moves_uncommanded(moves: &Uncommanded) -> String {
    let length = |metres: f64| difference(Signal::Position, metres);
    let share = |metres: f64| format!("{} ({} %)", length(metres), significant(100.0 * metres / moves.all_m, 2));
    let parts: Vec<String> =
        [(moves.at_neutral_m, "while the command is at neutral"), (moves.against_m, "against the command")]
            .into_iter()
            .filter(|(metres, _)| *metres > 0.0)
            .map(|(metres, when)| format!("{} {when}", share(metres)))
            .collect();
    let never = match (moves.is_never_asked, moves.only_retracts) {
        (true, true) => "; the command never asks it to retract",
        (true, false) => "; the command never asks it to go that way",
        (false, _) => "",
    };
    format!(
        "of {} that the rod goes in all, it goes {}{never} (most of it at once in {} from {} to {} s): is a command missing, or does something else move it?",
        length(moves.all_m),
        parts.join(" and "),
        moves.recording,
        significant(moves.from_s, 3),
        significant(moves.to_s, 3)
    )
}

fn supply_sags(sag: &SupplySag) -> String {
    format!(
        "supply_pressure falls by {} while the command is at neutral ({} from {} to {} s): does another consumer share the pump?",
        difference(Signal::SupplyPressure, sag.by_pa),
        sag.recording,
        significant(sag.from_s, 3),
        significant(sag.to_s, 3)
    )
}

/// What a machine file may lack where nothing recorded says what.
fn possible(diagnosis: &Diagnosis) -> String {
    let found = &diagnosis.structure;
    let possible = match found.driven_by {
        Some(InputPoint::Force) => {
            "another force that is not recorded, a mass that is not one piece, a drive of another kind"
        }
        _ if found.knows_supply => "a command that is not recorded, a valve or a load of another kind",
        _ => {
            "another consumer that shares the pump (the supply pressure is not recorded), a command that is not recorded, a valve or a load of another kind"
        }
    };
    format!("nothing that is recorded says why; possible are: {possible}")
}

/// What drives the model.
fn input(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.structure.driven_by {
        Some(InputPoint::Spool) => "the spool",
        Some(InputPoint::Pump) => "the pump's speed",
        Some(InputPoint::Flow) => "the flow",
        Some(InputPoint::Force) => "the force",
        Some(InputPoint::Command) | None => "the command",
    }
}

/// What it would be otherwise.
fn drive(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.structure.driven_by {
        Some(InputPoint::Pump) => "hydraulic drive moved by a pump",
        Some(InputPoint::Flow) => "hydraulic drive moved by that flow",
        Some(InputPoint::Force) => "mass that is free to move",
        Some(InputPoint::Spool | InputPoint::Command) | None => "hydraulic drive moved by a valve",
    }
}
