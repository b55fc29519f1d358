//! The values of data sheets and drawings: the one table of flags, questions and units.

use std::collections::BTreeMap;

use recording::Dimension;

use super::quantity::{Quantity, QuantityError};

/// Which drives an item belongs to, and whether it is required there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// Every drive needs it.
    Always,
    /// Every drive with a valve needs it.
    OfValve,
    /// Every drive with a valve needs at least one of these flags.
    OneOf(&'static [&'static str]),
    /// It makes the drive a pump-controlled one.
    MakesPump,
    /// A drive with a valve may have it; the text says what is assumed otherwise.
    MayOfValve(&'static str),
    /// Any drive may have it; the text says what is assumed otherwise.
    May(&'static str),
}

/// Which numbers are possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Range {
    Positive,
    NotNegative,
    /// From 0 to less than 1.
    Share,
    Any,
}

/// How an item is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    /// The flag, without dashes.
    pub flag: &'static str,
    /// What it is; a phrase.
    pub what: &'static str,
    /// A possible answer.
    pub example: &'static str,
    /// Who needs it.
    pub need: Need,
    dimensions: &'static [Dimension],
    range: Range,
}

macro_rules! items {
    ($($item:ident $flag:literal $need:expr, [$($dimension:ident)+] $range:ident, $example:literal, $what:literal;)*) => {
        /// One value of a data sheet or a drawing.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Item { $(#[doc = $what] $item,)* }

        impl Item {
            /// Every item, in the order in which they are asked for.
            pub const ALL: &'static [Item] = &[$(Item::$item,)*];

            /// How it is asked for.
            #[must_use]
            pub const fn question(self) -> Question {
                match self {
                    $(Item::$item => Question {
                        flag: $flag, what: $what, example: $example, need: $need,
                        dimensions: &[$(Dimension::$dimension,)+], range: Range::$range,
                    },)*
                }
            }
        }
    };
}

use Need::{Always, MakesPump, May, MayOfValve, OfValve, OneOf};

/// Flags that say how fast a spool is.
const SPEEDS: &[&str] = &["valve-response", "valve-frequency", "valve-natural-frequency"];

items! {
    Bore "bore" Always, [Length] Positive, "63mm", "Diameter of the piston";
    Rod "rod" Always, [Length] NotNegative, "40mm", "Diameter of the rod, on side B";
    Stroke "stroke" Always, [Length] Positive, "300mm", "Length of travel";
    Mass "mass" Always, [Mass] Positive, "18.3kg", "Moving mass: rod, piston, tool";
    Supply "supply" Always, [Pressure] Positive, "70bar", "Supply pressure; of a pump drive, the one its relief valve is set to";
    PumpDisplacement "pump-displacement" MakesPump, [Displacement] Positive, "16cm3/rev",
        "Oil per turn of a pump in place of a valve; it feeds the cylinder directly";
    RatedFlow "rated-flow" OfValve, [Flow] Positive, "40l/min", "Rated flow of the valve; at the rated pressure drop and signal";
    RatedDrop "rated-drop" OfValve, [Pressure] Positive, "5bar",
        "Rated pressure drop, over one edge or over both; usually 35 bar an edge of servo valves, 5 bar of proportional ones";
    RatedSignal "rated-signal" OfValve, [Voltage Current] Positive, "10V", "Signal at which the valve is fully open";
    ValveResponse "valve-response" OneOf(SPEEDS), [Time] Positive, "50ms", "Time of the spool from 0 to 90 %; after a small step, dead time included";
    ValveFrequency "valve-frequency" OneOf(SPEEDS), [Frequency] Positive, "20Hz",
        "Frequency at which the spool is 90 degrees late; for a small signal";
    NaturalFrequency "valve-natural-frequency" OneOf(SPEEDS), [Frequency] Positive, "25Hz", "Natural frequency of the spool; as a second-order system";
    ValveDamping "valve-damping" MayOfValve("80 %"), [Ratio] Positive, "70%", "Damping ratio of the spool: below 100 % it overshoots";
    Overlap "overlap" MayOfValve("none, as of a zero-lapped valve"), [Ratio] Share, "15%",
        "Overlap: share of the spool's travel at the rated signal that passes no oil, to each side";
    SpoolAtRated "spool-at-rated" MayOfValve("100 %"), [Ratio] Positive, "100%", "What the spool's sensor reads at the rated signal";
    ValveStrokeTime "valve-stroke-time" MayOfValve("no limit"), [Time] Positive, "50ms",
        "Time from centre to the rated opening at the spool's largest speed";
    FlowLimit "flow-limit" MayOfValve("no limit"), [Flow] Positive, "18l/min", "Most that the supply delivers";
    HoseLength "hose-length" May("a dead volume of a twentieth of the chamber"), [Length] NotNegative, "1m", "Length of hose or pipe from valve to cylinder, each side";
    HoseDiameter "hose-diameter" May("as the length"), [Length] Positive, "8mm", "Inner diameter of hose or pipe";
    DeadVolume "dead-volume" May("as the hose's length"), [Volume] NotNegative, "50cm3", "Further oil on each side that the piston never displaces";
    BulkModulus "bulk-modulus" May("1200 MPa"), [Pressure] Positive, "1200MPa", "Bulk modulus of the oil, with the usual bit of air";
    Friction "friction" May("a tenth of the force at supply pressure"), [Force] NotNegative, "1.5kN", "Friction at full speed";
    Load "load" May("none"), [Force] Any, "-2.5kN", "Constant external force on the rod; positive extends";
}

impl Item {
    /// Reads an answer.
    ///
    /// # Errors
    /// If the text is not a number with a unit of this item, or its value is impossible for this item.
    pub fn parse(self, text: &str) -> Result<Quantity, QuantityError> {
        let Question { dimensions, example, range, .. } = self.question();
        let quantity = Quantity::parse(text, dimensions, example)?;
        let (possible, expected) = match range {
            Range::Positive => (quantity.si > 0.0, "more than 0"),
            Range::NotNegative => (quantity.si >= 0.0, "0 or more"),
            Range::Share => ((0.0..1.0).contains(&quantity.si), "from 0 to less than 100 %"),
            Range::Any => (true, "a number"),
        };
        if possible {
            Ok(quantity)
        } else {
            Err(QuantityError::OutOfRange { text: text.trim().to_owned(), expected, example })
        }
    }

    /// Whether a drive of this kind has such a value at all.
    #[must_use]
    pub const fn belongs(self, pump: bool) -> bool {
        match self.question().need {
            Always | May(_) => true,
            OfValve | MayOfValve(_) | OneOf(_) => !pump,
            MakesPump => pump,
        }
    }

    /// Whether a drive of this kind requires it, whatever else is given.
    #[must_use]
    pub const fn is_needed(self, pump: bool) -> bool {
        match self.question().need {
            Always => true,
            OfValve => !pump,
            MakesPump => pump,
            May(_) | MayOfValve(_) | OneOf(_) => false,
        }
    }
}

/// The values that were given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answers(BTreeMap<Item, Quantity>);

impl Answers {
    /// Sets an answer.
    pub fn insert(&mut self, item: Item, quantity: Quantity) {
        self.0.insert(item, quantity);
    }

    /// An answer, where there is one.
    #[must_use]
    pub fn get(&self, item: Item) -> Option<&Quantity> {
        self.0.get(&item)
    }

    /// Whether the answers describe a pump-controlled drive.
    #[must_use]
    pub fn is_pump(&self) -> bool {
        self.get(Item::PumpDisplacement).is_some()
    }

    /// The required items of this drive that are missing, in the order of the questions.
    #[must_use]
    pub fn missing(&self) -> Vec<Item> {
        let pump = self.is_pump();
        let given =
            |flag: &&str| Item::ALL.iter().any(|item| item.question().flag == *flag && self.get(*item).is_some());
        let lacks = |item: &Item| match item.question().need {
            // The first of them stands for all.
            OneOf(flags) => !pump && flags.first() == Some(&item.question().flag) && !flags.iter().any(given),
            _ => item.is_needed(pump) && self.get(*item).is_none(),
        };
        Item::ALL.iter().copied().filter(lacks).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_example_is_a_possible_answer_and_every_flag_is_there_once() {
        let mut flags = Vec::new();
        for item in Item::ALL {
            let question = item.question();
            item.parse(question.example).unwrap();
            assert!(!flags.contains(&question.flag), "{}", question.flag);
            flags.push(question.flag);
        }
    }

    #[test]
    fn impossible_numbers_are_refused_with_what_would_do() {
        let message = |item: Item, text| item.parse(text).unwrap_err().to_string();
        assert!(message(Item::Bore, "-63mm").contains("more than 0"));
        assert!(message(Item::Overlap, "100%").contains("less than 100 %"));
        assert!(message(Item::Supply, "70mm").contains("Pa, kPa, MPa, bar, psi"));
        assert!(Item::Load.parse("-2.5kN").is_ok());
    }

    #[test]
    fn what_is_missing_depends_on_what_feeds_the_cylinder() {
        let mut answers = Answers::default();
        assert!(answers.missing().contains(&Item::RatedFlow));
        answers.insert(Item::PumpDisplacement, Item::PumpDisplacement.parse("16cm3/rev").unwrap());
        assert_eq!(answers.missing(), [Item::Bore, Item::Rod, Item::Stroke, Item::Mass, Item::Supply]);
    }
}
