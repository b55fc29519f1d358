//! A misfit without a named effect is still reduced by a table, unless it happened only once.

use diagnosis::correction_table::{Quantity, Unnamed, improved};
use diagnosis::localisation::{Case as Located, Location, Sought, locate};
use diagnosis::selection::{Candidate, Question};
use identification::experiment::Prepared;
use identification::fit::{Free, settle};
use model_core::machine::Parameter as P;
use recording::Signal;
use virtual_plant::PlantEffect;

use super::bed::{Case, valve_case};

/// The table for a case that the catalogue does not describe, with the misfit of the position on held-out recordings before and after
/// (root mean square over noise).
fn tabled(case: &Case, with: impl Fn(Location) -> Location) -> Option<(Unnamed, [f64; 2])> {
    let (training, held) = (case.prepared(&case.training), case.prepared(&case.held_out));
    let (training_refs, held_refs): (Vec<&Prepared>, Vec<&Prepared>) =
        (training.iter().collect(), held.iter().collect());
    let judged: Vec<Signal> = training[0].channels.iter().map(|channel| channel.signal).collect();
    let scene = case.scene(&training[0], &judged);
    let base_parameters: Vec<Free> = diagnosis::base_parameters(&case.file);
    let question =
        Question { scene: &scene, base_parameters: &base_parameters, hypotheses: &[], training: &training_refs };
    let base = Candidate::rough(&question, None).unwrap();
    let cases: Vec<Located<'_>> = case
        .training
        .iter()
        .zip(&training)
        .zip(&base.fit.starts)
        .map(|((recording, prepared), &start)| Located { recording, prepared, start })
        .collect();
    let location = with(
        locate(&Sought {
            machine: &base.fit.machine,
            load: case.file.load_source,
            cases: &cases,
            named: &[],
            predicted_gains: &[],
        })
        .unwrap(),
    );
    let (candidate, unnamed) = improved(&question, &base, &location, &cases, &held_refs).unwrap()?;
    assert!((candidate.fit.machine.get(P::TableQuantity) - f64::from(unnamed.quantity as u8)).abs() < 0.5);
    let missed = [&base, &candidate].map(|candidate| {
        let machine = &candidate.fit.machine;
        let (mut square, mut rows) = (0.0, 0.0);
        for case in &held {
            let residuals = identification::fit::standardised(machine, case, settle(machine, case).unwrap()).unwrap();
            let at = case.channels.iter().position(|channel| channel.signal == Signal::Position).unwrap();
            square += residuals[at].iter().map(|value| value * value).sum::<f64>();
            rows += residuals[at].len() as f64;
        }
        (square / rows).sqrt()
    });
    Some((unnamed, missed))
}

/// The test does not fix the state of the table: dry friction changes in a step where the velocity reverses, which seven nodes over the
/// velocity cannot follow, and the pressure against which the rod returns shows the direction as well.
#[test]
fn dry_friction_without_its_name_becomes_a_table_of_force() {
    let case = valve_case(31, PlantEffect::named("coulomb-friction", 900.0), true, None);
    let (table, [before, after]) = tabled(&case, |location| location).unwrap();
    println!("{}: position {before:.2} to {after:.2} times its noise", report::wording::correction_table(&table));
    assert_eq!(table.quantity, Quantity::Force);
    assert!(after < 0.5 * before, "{before} {after}");
}

#[test]
fn a_push_in_one_recording_does_not_become_a_table() {
    let push = super::once::push();
    let case = valve_case(11, None, true, Some(&(1, push)));
    // Even where the localisation does not show that it happens once.
    let found = tabled(&case, |location| Location {
        shape: diagnosis::localisation::error_shape::Shape::Everywhere,
        ..location
    });
    assert!(found.is_none(), "{found:?}");
}
