//! Instructions and estimated cycles of a function in an image for the target, a tick from its entry to its return to its caller:
//! `cargo run --release -p system-tests --example cycles -- IMAGE --cpu m4f --step NAME --caller NAME`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use system_tests::cycles::Costs;
use system_tests::cycles::traced::{Counted, trace};
use system_tests::emulator::Processor;

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Cpu {
    M4f,
    M3,
}

/// Weighs each instruction of a function by the processor's timing table; nothing is measured on silicon.
#[derive(Parser)]
struct Arguments {
    /// An ELF file with its symbols, for `mps2-an386` or `mps2-an385` of QEMU.
    image: PathBuf,
    /// The processor.
    #[arg(long)]
    cpu: Cpu,
    /// The function that is counted; several are counted together.
    #[arg(long, required = true)]
    step: Vec<String>,
    /// The function that calls it; it must not be inlined.
    #[arg(long)]
    caller: String,
    /// Ticks that are left out at the start.
    #[arg(long, default_value_t = 0)]
    skip: usize,
    /// Ticks that are counted.
    #[arg(long, default_value_t = 300)]
    ticks: usize,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let processor = match arguments.cpu {
        Cpu::M4f => Processor::M4F,
        Cpu::M3 => Processor::M3,
    };
    let functions: Vec<&str> = arguments.step.iter().map(String::as_str).collect();
    let at_most = arguments.skip.saturating_add(arguments.ticks);
    let counted = Counted { functions: &functions, caller: &arguments.caller, at_most };
    let traced = match trace(processor, &arguments.image, counted) {
        Ok(traced) => traced,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    let Some(costs) = traced.ticks.get(arguments.skip..).and_then(Costs::of) else {
        eprintln!("{} ticks in all, none behind the first {}", traced.ticks.len(), arguments.skip);
        return ExitCode::FAILURE;
    };
    for (which, cost) in [("mean", costs.mean), ("worst", costs.worst)] {
        let [low, nominal, high] = cost.cycles;
        println!("{which}: {:.1} instructions, {nominal:.0} cycles, {low:.0} to {high:.0}", cost.instructions);
    }
    ExitCode::SUCCESS
}
