//! The directions of encoder, command, spool and pressures, by a move of 1 mm each way without any loop.
//!
//! ```text
//! u = neutral + ramp                       until the rod has moved 1 mm, either way, or the ramp has ended
//! (x − x at rest)·way                      early: above −0.02, and half of what the valve's model says at 1.2 V
//! (y − y at rest)·way                      not below −0.3 mm, and 1 mm in the end
//! mean of pA − pB, extending less retracting    > 0
//! ```
//!
//! The loops are open, because a loop around a turned sensor drives the rod to its end. The spool is judged first, within the overlap: with the
//! command's wires exchanged, the rod has not moved yet. A cylinder with Ab < Aa moves out at lower pressures than it moves in, so each pressure
//! alone falls when the rod extends; their difference rises, for friction and for the areas.

use super::check;
use super::reading::{Expected, Reading, Refusal, Way, What};
use super::rules::{Rules, Seen};
use super::step::Step;
use crate::supervision::Log;

/// Way that the rod has to move, µm, and the part of it in which pressures count.
pub(super) const WAY_UM: i32 = 1000;
const STEADY_UM: i32 = 500;
/// Way against the command after which it is refused, µm.
const AGAINST_UM: i32 = 300;
/// The same of the spool, thousandths.
const SPOOL_AGAINST: i32 = 20;
/// Command at which the spool must have gone half of its way, µV.
const SPOOL_AT_UV: i32 = 1_200_000;

/// Where the rod and the spool rested before a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Rested {
    position_um: i32,
    spool: Option<i32>,
}

/// The two moves: state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Direction {
    way: Way,
    /// Moves that have ended.
    ended: u8,
    /// Periods at rest, or at the end of the ramp.
    waited: u32,
    hand_uv: i32,
    /// `None` at rest.
    moving: Option<Rested>,
    spool_judged: bool,
    /// Sum and number of the pressures' differences: extending, retracting.
    sums: [(i64, i64); 2],
    /// Where the last move began.
    began_um: i32,
}

impl Direction {
    /// The first move goes this way.
    pub(super) const fn new(way: Way) -> Self {
        let (moving, spool_judged, sums) = (None, false, [(0, 0); 2]);
        Self { way, ended: 0, waited: 0, hand_uv: 0, moving, spool_judged, sums, began_um: 0 }
    }

    /// The command beyond neutral, µV; positive extends.
    pub(super) const fn hand_uv(&self) -> i32 {
        self.way.sign() * self.hand_uv
    }

    /// How far the rod has gone, where it should have gone all its way.
    pub(super) fn rod(&self, position_um: i32) -> Refusal {
        let found = (position_um - self.began_um) * self.way.sign();
        Refusal::Value(Reading { what: What::Rod(self.way), found, expected: Expected::AtLeast(WAY_UM) })
    }

    /// A period; the verdict, once there is one.
    pub(super) fn seen<L: Log>(&mut self, rules: &Rules, seen: &Seen, log: &mut L) -> Option<Result<(), Refusal>> {
        match self.moving {
            None => self.rest(rules, seen, log),
            Some(rested) => self.go(rules, seen, rested, log).err().map(Err),
        }
    }

    fn rest<L: Log>(&mut self, rules: &Rules, seen: &Seen, log: &mut L) -> Option<Result<(), Refusal>> {
        self.waited += 1;
        if self.waited <= rules.rest {
            return None;
        }
        if self.ended > 0 {
            let found = (seen.position_um - self.began_um) * self.way.sign();
            let expected = Expected::AtLeast(WAY_UM / 2);
            if let Err(refusal) = check(log, Step::Direction, Reading { what: What::Rod(self.way), found, expected }) {
                return Some(Err(refusal));
            }
            if self.ended == 2 {
                return Some(self.pressures(rules, log));
            }
            self.way = self.way.other();
        } else if let Some([a, b]) = seen.pressures_kpa {
            let low = Expected::AtMost(rules.low_kpa);
            for (what, found) in [(What::PressureA, a), (What::PressureB, b)] {
                if let Err(refusal) = check(log, Step::Direction, Reading { what, found, expected: low }) {
                    return Some(Err(refusal));
                }
            }
        }
        self.moving = Some(Rested { position_um: seen.position_um, spool: seen.spool });
        (self.began_um, self.waited, self.spool_judged) = (seen.position_um, 0, false);
        None
    }

    fn go<L: Log>(&mut self, rules: &Rules, seen: &Seen, rested: Rested, log: &mut L) -> Result<(), Refusal> {
        let moved = (seen.position_um - rested.position_um) * self.way.sign();
        if let (Some(spool), Some(from)) = (seen.spool, rested.spool) {
            self.judge_spool(rules, (spool - from) * self.way.sign(), log)?;
        }
        let ended = self.hand_uv >= rules.most_uv;
        self.waited += u32::from(ended);
        if moved <= -AGAINST_UM || self.waited > rules.rest {
            return Err(self.rod(seen.position_um));
        }
        if moved >= STEADY_UM
            && let Some([a, b]) = seen.pressures_kpa
        {
            let (sum, number) = &mut self.sums[usize::from(self.way == Way::Retracts)];
            (*sum, *number) = (*sum + i64::from(a - b), *number + 1);
        }
        if moved >= WAY_UM {
            (self.moving, self.hand_uv, self.waited) = (None, 0, 0);
            self.ended += 1;
        } else if !ended {
            self.hand_uv += rules.slope_uv;
        }
        Ok(())
    }

    fn judge_spool<L: Log>(&mut self, rules: &Rules, found: i32, log: &mut L) -> Result<(), Refusal> {
        let half = rules.spool_per_v * (SPOOL_AT_UV / 1000) / 2000;
        let reading = Reading { what: What::Spool(self.way), found, expected: Expected::AtLeast(half) };
        if found <= -SPOOL_AGAINST {
            return Err(Refusal::Value(reading));
        }
        if self.hand_uv >= SPOOL_AT_UV && !self.spool_judged {
            self.spool_judged = true;
            check(log, Step::Direction, reading)?;
        }
        Ok(())
    }

    fn pressures<L: Log>(&self, rules: &Rules, log: &mut L) -> Result<(), Refusal> {
        let [(out, outs), (back, backs)] = self.sums;
        if outs == 0 || backs == 0 {
            return Ok(());
        }
        let found = i32::try_from(out / outs - back / backs).unwrap_or(i32::MAX);
        let expected = Expected::AtLeast(rules.difference_kpa);
        check(log, Step::Direction, Reading { what: What::PressureSigns, found, expected })
    }
}
