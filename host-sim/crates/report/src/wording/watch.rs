//! What the monitor says of a recording: whether the drive is in its band, and where it left it.

use recording::display_unit::{difference, significant};
use watch::{Left, Link, Seen, Watched};

/// A link of the model, as people name it.
const fn link(link: Link) -> &'static str {
    match link {
        Link::Valve => "valve",
        Link::FlowAndChambers => "flow + chambers",
        Link::Mechanics => "mechanics",
    }
}

/// Of several recordings, where the drive left its band first and in how many; or how near it came.
#[must_use]
pub fn watched(all: &[Watched]) -> String {
    let out: Vec<(&Watched, Left)> = all.iter().filter_map(|one| Some((one, one.left?))).collect();
    let recordings = |count: usize| if count == 1 { "1 recording".to_owned() } else { format!("{count} recordings") };
    if let Some((first, left)) = out.first() {
        let of = if all.len() == 1 { String::new() } else { format!(" in {} of {} recordings", out.len(), all.len()) };
        return format!("outside its band{of}: {}, {}", first.recording, left_at(left));
    }
    let nearest = all.iter().flat_map(|one| one.signals.iter().map(move |seen| (one, seen)));
    let nearest = nearest.max_by(|a, b| share(a.1).total_cmp(&share(b.1)));
    let nearest = nearest.map_or_else(String::new, |(one, seen)| {
        format!(", at most {} % of the limit ({}, {})", significant(100.0 * share(seen), 2), seen.signal, one.recording)
    });
    format!("in its band: {}{nearest}", recordings(all.len()))
}

/// Where the drive left its band.
fn left_at(left: &Left) -> String {
    let Left { signal, link: of, at_s, off_by } = left;
    let side = if *off_by > 0.0 { "above" } else { "below" };
    let by = difference(*signal, off_by.abs());
    format!("{}: {signal} is {by} {side} the model at {} s", link(*of), significant(*at_s, 4))
}

/// How near the limit a signal came: 1 is at the limit.
#[must_use]
pub fn share(seen: &Seen) -> f64 {
    seen.square / seen.limit
}

#[cfg(test)]
mod tests {
    use recording::Signal;

    use super::*;

    fn watched_one(recording: &str, square: f64, left: Option<Left>) -> Watched {
        let seen = Seen { signal: Signal::Position, square, at_s: 1.5, limit: 4.0 };
        Watched { recording: recording.into(), duration_s: 4.0, signals: vec![seen], left }
    }

    #[test]
    fn the_first_recording_outside_the_band_is_told_with_its_link_and_the_nearest_where_none_is() {
        let left = Left { signal: Signal::Position, link: Link::Mechanics, at_s: 2.311, off_by: -0.0032 };
        let (good, bad) = (watched_one("a.csv", 1.2, None), watched_one("b.csv", 9.0, Some(left)));
        assert_eq!(
            watched(&[good.clone(), bad]),
            "outside its band in 1 of 2 recordings: b.csv, mechanics: position is 3.20 mm below the model at 2.311 s"
        );
        assert_eq!(watched(&[good]), "in its band: 1 recording, at most 30 % of the limit (position, a.csv)");
    }
}
