//! What a reader of a static recording should know, in sentences.

use identification::static_curve::{Remark, Shape, Statics};

use super::{place, short};

pub(super) fn sentence(remark: &Remark, statics: &Statics) -> String {
    let output = &statics.output.header;
    let plain = match remark {
        Remark::NoRate { clock: true } => "the clock is not used: only what does not depend on the rate is read",
        Remark::NoRate { clock: false } => {
            "rows in the order of the file, no clock: only what does not depend on the rate is read"
        }
        Remark::LagOrLoop { lag_s } => {
            let as_lag = lag_s.map_or_else(String::new, |lag_s| format!(" (as a lag: {} s)", short(lag_s)));
            return format!(
                "the loop is hysteresis or a lag of valve or meter{as_lag}: one sweep cannot tell. Sweep at another period and give both to --recording"
            );
        }
        Remark::NoGain => return no_gain(statics),
        Remark::NowhereSmall => {
            "no output is small against the largest one, or its line meets zero too far outside: no null, no dead zone and no gain at small \
             outputs is read"
        }
        Remark::Staircase(stairs) => {
            let coarse = stairs.from_magnitude > 0.0;
            let from = if coarse { format!(" from ±{} on", short(stairs.from_magnitude)) } else { String::new() };
            let also = if coarse { ", and a different gain there is attributed to the meter" } else { "" };
            return format!(
                "instrument: {output} stands on {} levels {} apart{from}: a staircase of the meter, not of the valve; the loop is read at the \
                 edges of its steps{also}",
                stairs.levels,
                short(stairs.step),
            );
        }
        Remark::Jump(jump) => {
            return format!(
                "instrument: {output} jumps from {} to {} near {} on every branch and nowhere else: attributed to the meter",
                short(jump.output.0),
                short(jump.output.1),
                place(jump.input, &statics.input)
            );
        }
        Remark::PressureEnds => {
            "the output is a pressure and ends at the supply's: this is not saturation of the valve"
        }
        Remark::SpoolOrOrifice => {
            "without a measured spool it cannot be decided whether spool or orifice stops following at the end"
        }
        Remark::EdgesOrOffset => {
            "edges of unequal distance from zero may be a dead-zone-asymmetry or an offset of the input: not separable here"
        }
        Remark::OneDirection => "one direction only: neither null nor the other side's dead zone",
        Remark::LimitStopOrSensor => {
            "a spool that stops may be at its solenoid's limit, at its stop or at the end of its sensor: not separable here"
        }
        Remark::PortHoldsEdge => {
            "a pressure at the valve's port holds the drop of the edge behind it as well as that of the line"
        }
    };
    plain.to_owned()
}

/// Why there is no gain.
fn no_gain(statics: &Statics) -> String {
    let nothing = "no gain, null, dead zone or saturation is read from it";
    match &statics.shape {
        Shape::Peak(_) => {
            format!(
                "one peak between two lower ends: where the output is the leakage of a valve at closed ports, this is its null leakage; {nothing}"
            )
        }
        Shape::Valley(_) => {
            format!(
                "one valley between two higher ends, as a meter without a sign shows a flow that changes its direction; {nothing}"
            )
        }
        Shape::Constant { .. } => {
            format!("the output changes along the input by no more than by chance: {nothing}")
        }
        Shape::BranchesDiffer => format!("way up and way down do not agree on one curve: {nothing}"),
        _ => format!("the output has the same value at several inputs, by more than scatter and loop: {nothing}"),
    }
}
