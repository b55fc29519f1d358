//! Coefficients of the chambers.

use super::Builder;
use crate::chambers::capacity::{Capacity, ChamberCapacity, LEAST_VOLUME, POLYTROPIC};
use crate::chambers::cavitation::Cavitation;
use crate::chambers::{ChamberEffects, Chambers, ExternalLeakage};
use crate::coefficients::bases::{GAIN_AIM, thinnest};
use crate::machine::{ATMOSPHERE_PA, LOWEST_FLOOR_PA, MachineError, Parameter as P};
use crate::mechanics::GAMMA;
use crate::number::{Number, Real};
use crate::ports::Flows;

/// Share of a pressure difference that leakage removes within a tick; from this share on, leakage is solved for. Explicitly computed, a share
/// of 2 is unstable.
const FAST_LEAKAGE: f64 = 0.5;

impl<R: Real> Builder<'_, R> {
    /// h·Q/(p·C): pressure rise over a tick at flow 1, for a chamber of capacity V/E0 + hose. (7)
    fn stiffness(&self, volume: P) -> R {
        R::constant(self.tick_s * self.bases.flow_m3_per_s / self.bases.pressure_pa) / self.capacity(volume)
    }

    /// The same at the least possible capacity.
    pub(super) fn stiffest(&self, volume: P) -> R {
        if self.machine.volume_share().is_nil() {
            self.stiffness(volume)
        } else {
            self.stiffness(volume) / self.least_capacity(volume)
        }
    }

    /// α = Ab/Aa. (5)
    pub(super) fn ratio(&self) -> R {
        self.get(P::AreaB) / self.get(P::AreaA)
    }

    pub(super) fn chambers<N: Number<Real = R>>(&self) -> Result<Chambers<N>, MachineError> {
        let (a, b) = (self.stiffest(P::VolumeA), self.stiffest(P::VolumeB));
        let gamma = R::constant(GAMMA);
        let [leakage, out_a, out_b] =
            [P::InternalLeakage, P::ExternalLeakageA, P::ExternalLeakageB].map(|leakage| self.leakage(leakage));
        Ok(Chambers {
            stiffness_a: self.gain::<N>("pressure rise in A per tick at full flow", P::VolumeA, a)?,
            stiffness_b: self.gain::<N>("pressure rise in B per tick at full flow", P::VolumeB, b)?,
            implicit: Flows {
                a: self.signal("pressure rise in A per tick at full flow", P::VolumeA, gamma * a)?,
                b: self.signal("pressure rise in B per tick at full flow", P::VolumeB, gamma * b)?,
            },
            ahead: [
                self.gain::<N>("force of a tick's pressure rise in A at full flow", P::VolumeA, gamma * a)?,
                self.gain::<N>(
                    "force of a tick's pressure rise in B at full flow",
                    P::VolumeB,
                    -(gamma * self.ratio() * b),
                )?,
            ],
            ratio: self.gain::<N>("area ratio B/A", P::AreaB, self.ratio())?,
            unity: self.steep::<N>("one", P::VolumeA, R::ONE)?,
            effects: ChamberEffects {
                leakage: self.signal("leakage at supply pressure", P::InternalLeakage, leakage)?,
                leaks_fast: (leakage * (a + b) + out_a * a + out_b * b).value() > FAST_LEAKAGE,
                external: if out_a.is_nil() && out_b.is_nil() {
                    None
                } else {
                    let tank = self.get(P::TankPressure) / R::constant(self.bases.pressure_pa);
                    Some(ExternalLeakage {
                        a: self.signal("leakage out of A at supply pressure", P::ExternalLeakageA, out_a)?,
                        b: self.signal("leakage out of B at supply pressure", P::ExternalLeakageB, out_b)?,
                        tank: self.signal("tank pressure", P::TankPressure, tank)?,
                    })
                },
                capacity: self.varying_capacity()?,
                cavitation: self.cavitation()?,
            },
        })
    }

    /// No chambers: pressures stay as they are and push nothing.
    pub(super) fn no_chambers<N: Number<Real = R>>(&self) -> Result<Chambers<N>, MachineError> {
        let none = self.gain::<N>("nothing", P::Stroke, R::ZERO)?;
        Ok(Chambers {
            stiffness_a: none,
            stiffness_b: none,
            implicit: Flows { a: N::ZERO, b: N::ZERO },
            ahead: [none; 2],
            ratio: none,
            unity: self.steep::<N>("one", P::Stroke, R::ONE)?,
            effects: ChamberEffects {
                leakage: N::ZERO,
                leaks_fast: false,
                external: None,
                capacity: None,
                cavitation: None,
            },
        })
    }

    /// Per unit, in the thinnest oil.
    fn leakage(&self, conductance: P) -> R {
        self.get(conductance) * R::constant(self.bases.pressure_pa / self.bases.flow_m3_per_s) / thinnest(self.machine)
    }

    /// Compressibility of a chamber: V/E0 and its hose. (7)
    pub(super) fn capacity(&self, volume: P) -> R {
        self.get(volume) / self.get(P::BulkModulus) + self.get(P::HoseCompliance)
    }

    /// The oil's share of the capacity.
    fn oil(&self, volume: P) -> R {
        self.get(volume) / self.get(P::BulkModulus) / self.capacity(volume)
    }

    /// Least volume of a chamber over that at mid-stroke.
    fn least_volume(&self, volume: P) -> R {
        if self.machine.volume_share().is_nil() {
            return R::ONE;
        }
        // Where the pressure rise per tick at flow 1 is the largest that the format is aimed at.
        let fits = R::ONE - (R::ONE - self.stiffness(volume) / R::constant(GAIN_AIM)) / self.oil(volume);
        if fits.value() >= 1.0 {
            R::ONE
        } else if fits.value() > LEAST_VOLUME {
            fits
        } else {
            R::constant(LEAST_VOLUME)
        }
    }

    /// Capacity at the least volume over that at mid-stroke, without air.
    fn least_capacity(&self, volume: P) -> R {
        R::ONE - self.oil(volume) * (R::ONE - self.least_volume(volume))
    }

    fn cavitation<N: Number<Real = R>>(&self) -> Result<Option<Cavitation<N>>, MachineError> {
        let floor = self.get(P::CavitationFloor);
        if floor.value() < LOWEST_FLOOR_PA {
            return Ok(None);
        }
        Ok(Some(Cavitation {
            floor: self.signal("least pressure", P::CavitationFloor, floor / R::constant(self.bases.pressure_pa))?,
            unity: self.steep::<N>("one", P::CavitationFloor, R::ONE)?,
            unsprung: self.unsprung()?,
        }))
    }

    fn varying_capacity<N: Number<Real = R>>(&self) -> Result<Option<Capacity<N>>, MachineError> {
        if self.machine.volume_share().is_nil() && self.get(P::AirShare).is_nil() {
            return Ok(None);
        }
        let chamber = |area: P, volume: P| -> Result<ChamberCapacity<N>, MachineError> {
            let reach = self.machine.volume_share() * self.get(area) * self.get(P::Stroke) / self.get(volume);
            let oil = self.oil(volume) / self.least_capacity(volume);
            let air = self.get(P::AirShare) * self.get(P::BulkModulus) / R::constant(POLYTROPIC * ATMOSPHERE_PA);
            Ok(ChamberCapacity {
                reach: self.steep::<N>("volume of a stroke", volume, reach)?,
                least: self.signal("least volume", volume, self.least_volume(volume))?,
                oil: self.steep::<N>("capacity of the oil", volume, oil)?,
                air: self.steep::<N>("capacity of the air", P::AirShare, air * oil)?,
            })
        };
        let per_atmosphere = R::constant(self.bases.pressure_pa / ATMOSPHERE_PA);
        Ok(Some(Capacity {
            a: chamber(P::AreaA, P::VolumeA)?,
            b: chamber(P::AreaB, P::VolumeB)?,
            is_airy: !self.get(P::AirShare).is_nil(),
            per_atmosphere: self.steep::<N>("pressure in atmospheres", P::SupplyPressure, per_atmosphere)?,
        }))
    }
}
