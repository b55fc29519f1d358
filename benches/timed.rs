//! Times of a step and a refit on this computer, for developers who change one of them: `cargo bench -p system-benches --bench timed`, by Criterion,
//! which also reports changes since its last run. Kept in the repository are `BENCHMARKS.md` (ratios within a run) and `instructions.txt` (counts).

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use system_benches::refit::Refit;
use system_benches::run::{InLanes, Run, START_M, random_commands, staggered};

use model_core::number::{PerUnit, Scalar};
use simulation::number::simd::LANES;
use system_tests::drives;
use virtual_plant::InitialState;

/// Ticks of a run: 4 s.
const TICKS: usize = 4000;

fn alone<N: Scalar<Real = f64>>(criterion: &mut Criterion, name: &str) {
    let machine = drives::press();
    let run = Run::<N>::new(&machine, &InitialState::at_rest(&machine, START_M));
    let (volts, mut rows) = (random_commands(TICKS), Vec::new());
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(TICKS as u64));
    group.bench_function("paper's model", |bencher| bencher.iter(|| run.paper(black_box(&volts), &mut rows)));
    group.bench_function("any effect possible", |bencher| bencher.iter(|| run.any(black_box(&volts), &mut rows)));
}

fn in_lanes(criterion: &mut Criterion) {
    let machine = drives::press();
    let four = InLanes::new(&machine, &InitialState::at_rest(&machine, START_M));
    let (twice, mut rows) = (random_commands(2 * TICKS), <[Vec<_>; LANES]>::default());
    let volts = staggered(&twice);
    let mut group = criterion.benchmark_group("ticks, f64, in SIMD lanes");
    group.throughput(Throughput::Elements((LANES * TICKS) as u64));
    group.bench_function("paper's model", |bencher| bencher.iter(|| four.paper(black_box(volts), &mut rows)));
    group.bench_function("any effect possible", |bencher| bencher.iter(|| four.any(black_box(volts), &mut rows)));
}

fn steps(criterion: &mut Criterion) {
    alone::<f64>(criterion, "ticks, f64");
    alone::<PerUnit>(criterion, "ticks, fixed point");
    in_lanes(criterion);
}

fn refit(criterion: &mut Criterion) {
    let case = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/press-63-40"));
    let refit = Refit::read(case).expect("the example is a case");
    let mut group = criterion.benchmark_group("refit");
    group.sample_size(10);
    group.bench_function("ten parameters, four recordings", |bencher| bencher.iter(|| refit.run().expect("it fits")));
}

criterion_group!(timed, steps, refit);
criterion_main!(timed);
