//! What the spool does beyond the paper's valve; its motion is computed in [`crate::spool::with_effects`].

/// An effect between the command and the spool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ValveEffect {
    /// Several plays of unequal width and weight in parallel, behind the rate limit.
    WeightedPlays {
        /// Difference in spool travel between settling from above and from below.
        width: f64,
    },
    /// A hysteresis that closes smoothly (Bouc and Wen), behind the rate limit.
    BoucWen {
        /// Difference in spool travel between settling from above and from below.
        width: f64,
        /// Travel over which it passes from one branch to the other.
        turning: f64,
    },
    /// The spool sticks: static and kinetic friction against the centring spring, in spool travel.
    Stiction {
        /// Difference of commanded and actual travel at which it breaks away.
        break_away: f64,
        /// Kinetic friction relative to static friction; the jump is shorter by this share.
        kinetic_share: f64,
        /// Time constant of the jump, s; 0: it jumps at once, and sticks again wherever it ends. Not used by a mass on a spring.
        jump_s: f64,
    },
    /// The neutral moves with time: a straight line with a slow sine added.
    NullDrift {
        /// Travel after one period; positive extends.
        travel: f64,
        /// Period of the sine, s.
        period_s: f64,
    },
    /// The solenoid's force saturates: set value s·tanh(w/s).
    Saturation {
        /// s, the travel that is never exceeded.
        ceiling: f64,
    },
    /// The momentum of the oil pushes the spool closed, and brakes it.
    FlowForce {
        /// Share of the opening per pressure drop over both open edges, 1/Pa.
        closing_per_pa: f64,
        /// Time per square root of that pressure, by which the flow resists a moving spool, s/√Pa.
        braking_s_per_root_pa: f64,
    },
}

impl ValveEffect {
    /// The name in the project's vocabulary.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::WeightedPlays { .. } | Self::BoucWen { .. } => "valve-hysteresis",
            Self::Stiction { .. } => "spool-stiction",
            Self::NullDrift { .. } => "null-drift",
            Self::Saturation { .. } => "solenoid-saturation",
            Self::FlowForce { .. } => "flow-force",
        }
    }
}
