//! The state machine: what the firmware does with the valve, and what changes that.
//!
//! One exhaustive match, [`Mode::next`]; its diagram is in `docs/firmware.md`, and a test compares the two. Only a command leads back
//! from a fault.

use super::fault::Response;

/// What is done with the valve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// The valve is neutral, no fault is active, and sensors are watched until following is commanded.
    Starting,
    /// The rod follows the set point.
    Following,
    /// The last good set point comes to rest, and the rod is held there.
    Holding,
    /// The command moves to neutral at a stated slope.
    RampingDown,
    /// The valve is neutral until somebody acknowledges the faults.
    Neutral,
}

/// What can change the mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// A fault was found; of several faults, the most severe response.
    Faulty(Response),
    /// The ramp has arrived.
    Arrived,
    /// A command.
    Commanded(Command),
}

/// What an operator, or the machine's own controller, commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// Follow the set point from now on.
    Follow,
    /// Stop at the stated slope.
    Stop,
    /// The faults are known and their causes gone.
    Acknowledge,
}

/// What is done once in a change of the mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Action {
    /// Nothing.
    Nothing,
    /// Model and loops start where the machine is.
    Synchronise,
    /// The active faults are forgotten.
    Forget,
}

/// What an event leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition {
    /// The mode from now on.
    pub mode: Mode,
    /// What is done once in the change.
    pub action: Action,
}

impl Mode {
    /// Every mode.
    pub const ALL: [Mode; 5] = [Mode::Starting, Mode::Following, Mode::Holding, Mode::RampingDown, Mode::Neutral];

    /// Whether the valve is commanded, and the model runs together with the machine.
    #[must_use]
    pub const fn is_running(self) -> bool {
        match self {
            Mode::Following | Mode::Holding | Mode::RampingDown => true,
            Mode::Starting | Mode::Neutral => false,
        }
    }

    /// What an event leads to.
    #[must_use]
    #[expect(clippy::match_same_arms, reason = "the table is read mode by mode")]
    pub const fn next(self, event: Event) -> Transition {
        use Action::{Forget, Nothing, Synchronise};
        use Command::{Acknowledge, Follow, Stop};
        use Event::{Arrived, Commanded, Faulty};
        use Mode::{Following, Holding, Neutral, RampingDown, Starting};

        let (mode, action) = match (self, event) {
            (Starting, Faulty(Response::Hold | Response::RampDown | Response::Neutral)) => (Neutral, Nothing),
            (Starting, Commanded(Follow)) => (Following, Synchronise),
            (Starting, Commanded(Stop | Acknowledge) | Arrived) => (Starting, Nothing),

            (Following, Faulty(Response::Hold)) => (Holding, Nothing),
            (Following, Faulty(Response::RampDown) | Commanded(Stop)) => (RampingDown, Nothing),
            (Following, Faulty(Response::Neutral)) => (Neutral, Nothing),
            (Following, Commanded(Follow | Acknowledge) | Arrived) => (Following, Nothing),

            (Holding, Commanded(Acknowledge)) => (Following, Forget),
            (Holding, Faulty(Response::RampDown) | Commanded(Stop)) => (RampingDown, Nothing),
            (Holding, Faulty(Response::Neutral)) => (Neutral, Nothing),
            (Holding, Faulty(Response::Hold) | Commanded(Follow) | Arrived) => (Holding, Nothing),

            (RampingDown, Faulty(Response::Neutral) | Arrived) => (Neutral, Nothing),
            (RampingDown, Faulty(Response::Hold | Response::RampDown)) => (RampingDown, Nothing),
            (RampingDown, Commanded(Follow | Stop | Acknowledge)) => (RampingDown, Nothing),

            (Neutral, Commanded(Acknowledge)) => (Starting, Forget),
            (Neutral, Faulty(Response::Hold | Response::RampDown | Response::Neutral)) => (Neutral, Nothing),
            (Neutral, Commanded(Follow | Stop) | Arrived) => (Neutral, Nothing),
        };
        Transition { mode, action }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::format;
    use std::string::{String, ToString};

    use super::*;

    const EVENTS: [(Event, &str); 7] = [
        (Event::Faulty(Response::Hold), "fault: hold"),
        (Event::Faulty(Response::RampDown), "fault: ramp down"),
        (Event::Faulty(Response::Neutral), "fault: neutral"),
        (Event::Arrived, "arrived at neutral"),
        (Event::Commanded(Command::Follow), "command: follow"),
        (Event::Commanded(Command::Stop), "command: stop"),
        (Event::Commanded(Command::Acknowledge), "command: acknowledge"),
    ];

    #[test]
    fn the_diagram_in_the_documents_is_this_state_machine() {
        let mut edges = BTreeSet::new();
        for mode in Mode::ALL {
            for (event, name) in EVENTS {
                let next = mode.next(event).mode;
                if next != mode {
                    edges.insert(format!("{mode:?} --> {next:?}: {name}"));
                }
            }
        }
        let text = include_str!("../../../docs/firmware.md");
        let drawn: BTreeSet<String> =
            text.lines().map(str::trim).filter(|line| line.contains(" --> ")).map(ToString::to_string).collect();
        let start = BTreeSet::from(["[*] --> Starting".to_string()]);
        assert_eq!(drawn, edges.union(&start).cloned().collect());
    }

    #[test]
    fn only_commands_lead_back_to_less_severe_modes() {
        let severity = |mode| match mode {
            Mode::Following => 0,
            Mode::Holding => 1,
            Mode::RampingDown => 2,
            Mode::Neutral | Mode::Starting => 3,
        };
        for mode in Mode::ALL {
            for (event, _) in EVENTS {
                let next = mode.next(event).mode;
                if !matches!(event, Event::Commanded(_)) {
                    assert!(severity(next) >= severity(mode), "{mode:?} {event:?}");
                    assert!(next != Mode::Starting || mode == Mode::Starting);
                }
            }
        }
    }

    #[test]
    fn a_fault_is_answered_by_its_response_or_a_more_severe_one() {
        for mode in Mode::ALL {
            for (response, at_least) in [
                (Response::Hold, &[Mode::Holding, Mode::RampingDown, Mode::Neutral][..]),
                (Response::RampDown, &[Mode::RampingDown, Mode::Neutral]),
                (Response::Neutral, &[Mode::Neutral]),
            ] {
                assert!(at_least.contains(&mode.next(Event::Faulty(response)).mode), "{mode:?} {response:?}");
            }
        }
    }

    #[test]
    fn faults_are_forgotten_by_acknowledging_only() {
        for mode in Mode::ALL {
            for (event, _) in EVENTS {
                let forgets = mode.next(event).action == Action::Forget;
                assert!(!forgets || event == Event::Commanded(Command::Acknowledge));
            }
        }
    }
}
