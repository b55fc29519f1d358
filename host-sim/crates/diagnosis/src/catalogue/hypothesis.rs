//! What the diagnosis needs to know of an effect to try it: its forms, their parameters and usual ranges, and the drives that can show it.

use std::fmt;

use identification::fit::Free;
use machine_file::LoadSource;
use model_core::effects::Effect;
use model_core::machine::{Machine, Parameter, Source};
use recording::Signal;
use simulation::InputPoint;

/// A link of the model, as a finding names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Subsystem {
    /// Command → spool.
    Valve,
    /// Spool and pressures → flows.
    Flow,
    /// Flows and velocity → pressures.
    Chambers,
    /// Forces → motion.
    Mechanics,
    /// Motion → measured motion.
    Sensing,
}

impl Subsystem {
    /// Whether what happens in this link moves the signal: only the valve moves the spool.
    #[must_use]
    pub fn reaches(self, signal: Signal) -> bool {
        self == Subsystem::Valve || signal != Signal::Spool
    }
}

impl fmt::Display for Subsystem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Subsystem::Valve => "valve",
            Subsystem::Flow => "flow",
            Subsystem::Chambers => "chambers",
            Subsystem::Mechanics => "mechanics",
            Subsystem::Sensing => "sensing",
        })
    }
}

/// An effect that produces nearly the same residual as another one, so that data may not distinguish the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LookAlike {
    /// Its name in the vocabulary.
    pub effect: &'static str,
    /// What distinguishes them.
    pub told_apart_by: &'static str,
}

/// What a hypothesis may know of a drive before it is fitted: where its effect parameters usually lie depends on the drive's size.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The nominal machine.
    pub machine: &'a Machine<f64>,
    /// Which signal drives the model.
    pub input_point: InputPoint,
    /// Where the load comes from.
    pub load: LoadSource,
    /// Signals that are measured and judged.
    pub judged: &'a [Signal],
    /// Lowest and highest recorded position, m; the whole stroke where none is recorded.
    pub travel_m: (f64, f64),
    /// Longest recording, s.
    pub duration_s: f64,
    /// Whether so few rows were recorded, in every recording, that nothing faster than 25 Hz shows.
    pub is_sparse: bool,
    /// Lowest pressure of a chamber in the recordings, by the sensors and by the model without effects, Pa; infinite where neither gives one.
    pub lowest_pa: f64,
    /// Whether it is asked what has changed since the machine file was written, so that it tells the values of this very drive.
    pub asks_since: bool,
    /// Effects that the machine file holds and that may have changed since it was written.
    pub held: &'a [&'static Hypothesis],
    /// Their amounts, where there is more than a tolerance of them.
    pub changeable: &'a [&'static EffectParameter],
}

impl Scene<'_> {
    /// How much there is of an effect that may have changed; 0 of any other, and of what is within its tolerance.
    #[must_use]
    pub fn before(&self, amount: &EffectParameter) -> f64 {
        if self.changeable.iter().any(|own| own.parameter == amount.parameter) {
            self.machine.get(amount.parameter)
        } else {
            0.0
        }
    }

    /// How an effect that may have changed acted then; `None` of any other, and of a rigid friction's stiffness.
    #[must_use]
    pub fn shape_then(&self, shape: &EffectParameter) -> Option<f64> {
        let is_own = |effect: &&Hypothesis| {
            let mut forms = effect.every_form().filter(|form| self.holds(form));
            forms.any(|form| form.iter().any(|own| own.parameter == shape.parameter))
        };
        let there = self.machine.get(shape.parameter);
        (there > 0.0 && self.held.iter().any(is_own)).then_some(there)
    }

    /// Whether a form is one of an effect that may have changed.
    #[must_use]
    pub fn holds(&self, form: Form) -> bool {
        self.held_in(form) > 0
    }

    /// How many of the amounts that may have changed a form has.
    fn held_in(&self, form: Form) -> usize {
        form.iter().filter(|effect_parameter| self.before(effect_parameter) != 0.0).count()
    }

    /// Whether this much of an amount is more, or less, than these base parameters leave open: of one that may have changed, beyond what was known of it.
    #[must_use]
    pub fn is_beyond(&self, base_parameters: &[Free], amount: &EffectParameter, value: f64) -> bool {
        if let Some(is_changed) = self.is_changed(amount, value) {
            return is_changed;
        }
        let cover = base_parameters.iter().find(|free| free.parameter == covered_by(amount.parameter));
        cover.and_then(|free| free.share_used(value)).map_or(value != 0.0, |share| share > 1.0)
    }

    /// Whether an amount that may have changed has done so; `None` of any other.
    #[must_use]
    pub fn is_changed(&self, amount: &EffectParameter, value: f64) -> Option<bool> {
        let before = self.before(amount);
        (before != 0.0).then(|| (value - before).abs() > AMOUNT_KNOWN * before.abs())
    }

    /// The force of the full supply on side A, N.
    #[must_use]
    pub fn full_force_n(&self) -> f64 {
        full_force_n(self.machine)
    }

    /// The flow at full opening and full supply pressure, m³/s.
    #[must_use]
    pub fn full_flow_m3_per_s(&self) -> f64 {
        full_flow_m3_per_s(self.machine)
    }

    /// Whether a signal is measured and judged.
    #[must_use]
    pub fn judges(&self, signal: Signal) -> bool {
        self.judged.contains(&signal)
    }
}

/// The force of the full supply on side A, N; see [`Machine::full_force_n`] for a mass that a force moves.
#[must_use]
pub fn full_force_n(machine: &Machine<f64>) -> f64 {
    machine.full_force_n()
}

/// The flow of a valve at full opening and full supply pressure, m³/s.
#[must_use]
pub fn full_flow_m3_per_s(machine: &Machine<f64>) -> f64 {
    let opened = machine.get(Parameter::FlowCoefficient) * machine.get(Parameter::SupplyPressure).sqrt();
    opened.min(machine.get(Parameter::FlowLimit))
}

/// An amount of an effect that a machine file holds is known to this share of itself: what differs by less, from one recording of a drive to another or by
/// what else a fit leaves open, has not changed. Source: half of what a strength may be off by, chosen.
pub(crate) const AMOUNT_KNOWN: f64 = 0.1;

/// How an effect parameter moves in a search.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// How much of the effect there is: positive, 0 is neutral. A search moves its logarithm; the range is the usual one.
    Amount(fn(&Scene<'_>) -> (f64, f64)),
    /// The same for an amount that is never small: far below its usual range it belongs to another effect.
    Firm(fn(&Scene<'_>) -> (f64, f64)),
    /// The same for an amount with which the residuals jump, so that they have no usable derivative.
    Jump(fn(&Scene<'_>) -> (f64, f64)),
    /// The same as an amount, of either sign; the value is the largest usual magnitude, 0 where a scene cannot show it.
    Signed(fn(&Scene<'_>) -> f64),
    /// How the effect acts, not how much: positive; a search moves its logarithm, and first tries this many points of the usual range.
    Shape(fn(&Scene<'_>) -> (f64, f64), usize),
    /// The same for a place, which may have either sign: a search moves it linearly, and first tries these shares of the usual range.
    Place(fn(&Scene<'_>) -> (f64, f64), &'static [f64]),
    /// A limit that a pressure does not fall below; the parameter's default is neutral, and every other value acts. Values at these shares of
    /// the usual range are tried, and the best is refined without derivatives. The value says nothing for or against the effect.
    Floor(fn(&Scene<'_>) -> (f64, f64), &'static [f64]),
    /// The same for a pressure that opens a valve.
    Setting(fn(&Scene<'_>) -> (f64, f64), &'static [f64]),
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug)]
pub struct EffectParameter {
    /// The machine's parameter.
    pub parameter: Parameter,
    /// How it moves, and where it usually lies.
    pub kind: Kind,
}

impl EffectParameter {
    /// The base parameter that acts like its negative, if there is one: a candidate model without this effect parameter uses that one instead.
    #[must_use]
    pub fn negative_of(&self) -> Option<Parameter> {
        // A constant force against extending is a negative constant load.
        (self.parameter == Parameter::LoadSpringForce).then_some(Parameter::LoadForce)
    }

    /// The least usual value of a time whose usual range depends on the length of the recordings; none of any other parameter.
    pub(crate) fn slow_from(&self, scene: &Scene<'_>) -> Option<f64> {
        let Kind::Shape(range, _) = self.kind else { return None };
        let short = Scene { duration_s: 0.0, ..scene.clone() };
        (range(scene) != range(&short)).then_some(range(scene).0)
    }
}

/// The bristles through which every law of dry friction acts before the rod slides: about as stiff as the oil columns, or stiffer. Bristles
/// softer than about a third of the oil columns are the effect presliding; all dry friction has stiffer ones. Each law has a rigid form
/// and one with bristles, because recordings without pressures hardly show the bristles.
pub(crate) const LUGRE: EffectParameter = EffectParameter {
    parameter: Parameter::PreslidingStiffness,
    kind: Kind::Shape(|scene| (softest_bristles(scene.machine), 30.0 * softest_bristles(scene.machine)), 1),
};

/// The stiffness of bristles that are as soft as the oil, N/m; of a mass without oil, those that a friction of 2 % of the full force bends by 12 µm,
/// as in a cylinder of 63 mm bore. Before rigid contacts slide they yield by 1 to 50 µm (Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30, 1994).
pub(crate) fn softest_bristles(machine: &Machine<f64>) -> f64 {
    const BENT_M: f64 = 12e-6;
    const USUAL_FRICTION: f64 = 0.02;
    match machine.source {
        Source::Valve | Source::Pump => machine.oil_spring_n_per_m(),
        Source::Force => USUAL_FRICTION * machine.full_force_n() / BENT_M,
    }
}

/// The effect parameters of an effect that are fitted together; the others stay neutral.
pub type Form = &'static [EffectParameter];

/// Whether dry friction of this form acts through bristles.
#[must_use]
pub fn is_elastic(form: Form) -> bool {
    form.iter().any(|effect_parameter| effect_parameter.parameter == LUGRE.parameter)
}

/// What an effect has in common with a plainer one.
#[derive(Clone, Copy, Debug)]
pub struct Extension {
    /// The plainer effect.
    pub plain: &'static str,
    /// Its effect parameter.
    pub given: Parameter,
    /// The extension's effect parameters that take its place.
    pub taken: &'static [Parameter],
}

/// An effect that can be switched on in the model.
#[derive(Clone, Copy, Debug)]
pub struct Hypothesis {
    /// Its name in the vocabulary.
    pub name: &'static str,
    /// Where it acts.
    pub subsystem: Subsystem,
    /// Its equation, for people.
    pub equation: &'static str,
    /// The forms in which it is fitted, the plainest first: the next ones have more effect parameters, or others.
    pub forms: &'static [Form],
    /// Effects that may be mistaken for it.
    pub look_alikes: &'static [LookAlike],
    /// Forms that refine these by further effect parameters: tried where one of the forms above was found, and kept where they remove three
    /// quarters of the misfit that the plainer form leaves.
    pub refined: &'static [Form],
    /// The effect that it is an extension of, if any: its additional effect parameters have to gain enough.
    pub extends: Option<Extension>,
    /// The test that distinguishes it from others.
    pub separated_by: &'static str,
    /// Where the physics is described.
    pub source: &'static str,
    /// Whether a drive in this scene can show it in the forms that are possible there.
    pub shows_in: fn(&Scene<'_>) -> bool,
}

impl Hypothesis {
    /// The plain effect that it extends, or itself.
    #[must_use]
    pub fn plainest(&self) -> &'static str {
        self.extends.map_or(self.name, |extension| extension.plain)
    }

    /// Every parameter of its own table in the machine file. The laws of friction share the parameter of the bristles.
    pub fn parameters(&self) -> impl Iterator<Item = Parameter> {
        let table = format!("effects.{}.", self.name);
        Parameter::ALL.iter().copied().filter(move |parameter| parameter.description().key.starts_with(&table))
    }

    /// Whether it acts slowly: the usual range of one of its times depends on the length of the recordings, so that the beginning
    /// of a long recording does not show it.
    #[must_use]
    pub fn is_slow(&self, scene: &Scene<'_>) -> bool {
        self.effect_parameters().any(|effect_parameter| effect_parameter.slow_from(scene).is_some())
    }

    /// All its forms, refined ones included.
    pub fn every_form(&self) -> impl Iterator<Item = Form> {
        self.forms.iter().chain(self.refined).copied()
    }

    /// The effect parameters of all its forms; one that several forms share comes once for each form.
    pub fn effect_parameters(&self) -> impl Iterator<Item = &'static EffectParameter> {
        self.every_form().flatten()
    }

    /// Its effect parameters that say how much of it there is.
    pub(crate) fn amounts(&self) -> impl Iterator<Item = &'static EffectParameter> {
        self.effect_parameters().filter(|effect_parameter| effect_parameter.is_amount())
    }

    /// The forms that a scene can show. Of an effect that may have changed those that have of its amounts as many as any form has: what it has become more
    /// of is no other form of it. They may be refined ones.
    pub fn forms_in<'a>(&'a self, scene: &'a Scene<'_>) -> impl Iterator<Item = Form> + 'a {
        let hidden = |effect_parameter: &EffectParameter| matches!(effect_parameter.kind, Kind::Signed(size) if size(scene) == 0.0);
        let most = self.every_form().map(|form| scene.held_in(form)).max().unwrap_or(0);
        let is_refined_only = self.forms.iter().all(|form| scene.held_in(form) < most);
        let refined = if is_refined_only { self.refined } else { &[] };
        let forms = self.forms.iter().chain(refined).copied();
        // Micrometres by which bristles yield show in a pressure, or in a position that is recorded fast enough.
        let shows_bristles = !scene.is_sparse || scene.judged.iter().any(|signal| signal.is_pressure());
        forms.filter(move |form| {
            scene.held_in(form) == most && !form.iter().any(hidden) && (shows_bristles || !is_elastic(form))
        })
    }

    /// The forms that refine one of its forms.
    pub fn refined_from(&self, plain: Form) -> impl Iterator<Item = Form> {
        let refines = move |form: &Form| {
            let has = |effect_parameter: &EffectParameter| {
                form.iter().any(|other| other.parameter == effect_parameter.parameter)
            };
            form.len() > plain.len() && plain.iter().all(has)
        };
        self.refined.iter().copied().filter(refines)
    }

    /// The forms that a refined one refines.
    pub fn plain_of(&self, finer: Form) -> impl Iterator<Item = Form> {
        let refines = move |plain: &Form| self.refined_from(plain).any(|form| std::ptr::eq(form, finer));
        self.forms.iter().copied().filter(refines)
    }

    /// Whether a drive in this scene can show it at all, in any form.
    #[must_use]
    pub fn is_testable(&self, scene: &Scene<'_>) -> bool {
        (self.shows_in)(scene) && self.forms_in(scene).next().is_some()
    }

    /// Whether such a drive can have it: what a force moves has neither valve nor oil.
    #[must_use]
    pub fn is_of(&self, source: Source) -> bool {
        source != Source::Force || Effect::named(self.name).is_none_or(|effect| source.has_effect(effect))
    }

    /// Whether the drive can have it, and the recordings come near the range in which it acts: a floor that no pressure reaches changes nothing.
    #[must_use]
    pub fn is_reached(&self, scene: &Scene<'_>) -> bool {
        self.is_of(scene.machine.source)
            && self.effect_parameters().all(|effect_parameter| match effect_parameter.kind {
                Kind::Floor(range, _) => scene.lowest_pa < range(scene).1,
                _ => true,
            })
    }

    /// Whether a machine already has it, beyond what is a tolerance among these base parameters.
    #[must_use]
    pub fn is_on(&self, machine: &Machine<f64>, base_parameters: &[Free]) -> bool {
        self.effect_parameters().any(|effect_parameter| match effect_parameter.neutral() {
            Some(neutral) => {
                let value = machine.get(effect_parameter.parameter);
                (value - neutral).abs() > tolerance(base_parameters, effect_parameter.parameter)
            }
            None => false,
        })
    }
}

/// The parameter whose tolerance covers an amount: of the friction of good seals there is one, whichever law describes it.
#[must_use]
pub fn covered_by(amount: Parameter) -> Parameter {
    match amount {
        Parameter::CoulombFriction
        | Parameter::AsymmetricExtending
        | Parameter::AsymmetricRetracting
        | Parameter::PositionFriction
        | Parameter::PreslidingForce => Parameter::StribeckForce,
        own => own,
    }
}

/// The largest magnitude of an amount within its tolerance; 0 where it has none.
#[must_use]
pub fn tolerance(base_parameters: &[Free], amount: Parameter) -> f64 {
    let known = base_parameters.iter().find(|free| free.parameter == covered_by(amount));
    known.and_then(Free::tolerance).unwrap_or(0.0)
}
