//! Columns of files, and which signals they hold, mapped by hand.

use recording::{ChannelMap, Signal, guess, survey_from};
use report::refused::Refused;
use serde_json::{Value, json};

use crate::desk::{Desk, Request};

/// The columns of each recording, with the signal that is mapped, known by its name or guessed.
pub(crate) fn columns(desk: &Desk, request: &Request) -> Result<Value, Refused> {
    let drive = request.machine()?;
    let channels = request.channels(drive.as_ref())?;
    let of_file = |name: &String| {
        let columns = survey_from(name, desk.bytes(name)?)?;
        let guesses = guess::channels(&columns);
        // What the reader itself takes; where it takes nothing, its error is told by `inspect`.
        let read = recording::read_from(name, desk.bytes(name)?, &channels);
        let taken = |header: &str| {
            let columns = read.as_ref().map(recording::Recording::columns).unwrap_or_default();
            columns.iter().find(|column| column.header == header).map(|column| column.signal.name())
        };
        let column = |column: &recording::Surveyed| {
            let header = column.header();
            let is_unused = channels.unused().iter().any(|known| *known == header || *known == column.name);
            let guessed = guesses.iter().find(|guess| guess.header == header);
            json!({
                "header": header, "read_as": taken(&column.name).or_else(|| taken(&header)),
                "unused": is_unused, "guess": guessed.map(|guess| guess.signal.name()), "why": guessed.map(|guess| guess.why),
            })
        };
        let told: Vec<Value> = columns.iter().map(column).collect();
        let error = read.as_ref().err().map(|error| String::from(Refused::explained(error)));
        Ok(json!({ "file": name, "columns": told, "error": error }))
    };
    let names = request.train.iter().chain(&request.holdout);
    let files = names.map(of_file).collect::<Result<Vec<Value>, Refused>>()?;
    let signals: Vec<&str> = Signal::ALL.iter().map(|signal| signal.name()).collect();
    Ok(json!({ "files": files, "signals": signals }))
}

/// The machine file with the maps of the request in its `[channels]`.
pub(crate) fn written(request: &Request) -> Result<String, Refused> {
    let mut drive = request.drive()?;
    let maps = ChannelMap::from_arguments(request.maps.iter().map(String::as_str))?;
    for (signal, mapping) in maps.iter() {
        // The readings of another column have another scale.
        let known = drive.file.channels.get(signal).filter(|known| known.header == mapping.header);
        let scale = known.and_then(|known| known.scale);
        drive.file.channels.insert(signal, recording::Mapping { scale, required: false, ..mapping.clone() });
    }
    request.unused.iter().for_each(|header| drive.file.channels.leave_unused(header));
    Ok(drive.file.to_text(&drive.name)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MACHINE: &str = include_str!("../../examples/press-63-40/machine.toml");

    fn request(maps: &str) -> Request {
        let machine = json!({ "name": "machine.toml", "text": MACHINE });
        let asked = format!(r#"{{ "machine": {machine}, "train": ["run.csv"], "maps": {maps} }}"#);
        serde_json::from_str(&asked).unwrap()
    }

    fn desk() -> Desk {
        let mut desk = Desk::default();
        desk.put(
            "run.csv".to_owned(),
            b"Zeit [s],Kolbenweg [mm],command [V],x\n0,1,2,3\n0.1,2,3,4\n0.2,3,4,5\n".to_vec(),
        );
        desk
    }

    #[test]
    fn a_column_tells_how_it_is_read_or_what_it_may_be() {
        let told = columns(&desk(), &request("[]")).unwrap();
        let told = told["files"][0]["columns"].as_array().unwrap();
        let of = |header: &str| told.iter().find(|column| column["header"] == header).unwrap();
        assert_eq!(of("Kolbenweg [mm]")["guess"], "position");
        assert_eq!(of("x")["guess"], Value::Null);
        let told = columns(&desk(), &request(r#"["time=Zeit [s]", "position=Kolbenweg [mm]"]"#)).unwrap();
        let told = &told["files"][0]["columns"];
        assert_eq!((&told[1]["read_as"], &told[2]["read_as"]), (&json!("position"), &json!("command")), "{told}");
    }

    #[test]
    fn a_column_that_was_mapped_is_left_unused_and_may_be_mapped_again() {
        let read = |text: &str| {
            let file = machine_file::read_text("machine.toml", text).unwrap();
            recording::read_from("run.csv", desk().bytes("run.csv").unwrap(), &file.channels)
        };
        let of = |text: &str, maps: &[&str], unused: &[&str]| {
            let machine = json!({ "name": "machine.toml", "text": text });
            let asked = json!({ "machine": machine, "train": ["run.csv"], "maps": maps, "unused": unused });
            serde_json::from_value::<Request>(asked).unwrap()
        };
        let mapped = written(&of(MACHINE, &["time=Zeit [s]", "position=Kolbenweg [mm]"], &[])).unwrap();
        assert!(read(&mapped).unwrap().has(Signal::Position));
        let without = written(&of(&mapped, &[], &["Kolbenweg [mm]", "command [V]"])).unwrap();
        assert!(!without.contains("position =") && without.contains("unused = ["), "{without}");
        let told = columns(&desk(), &of(&without, &[], &[])).unwrap();
        let of_column = |header: &str| {
            let told = told["files"][0]["columns"].as_array().unwrap();
            told.iter().find(|column| column["header"] == header).unwrap().clone()
        };
        for header in ["Kolbenweg [mm]", "command [V]"] {
            assert_eq!(
                (&of_column(header)["read_as"], &of_column(header)["unused"]),
                (&Value::Null, &json!(true)),
                "{told}"
            );
        }
        assert_eq!(of_column("x")["unused"], false);
        let again = written(&of(&without, &["position=Kolbenweg [mm]", "command=command [V]"], &[])).unwrap();
        let again = read(&again).unwrap();
        assert!(again.has(Signal::Position) && again.has(Signal::Command));
        let before_there_is_a_machine = columns(
            &desk(),
            &serde_json::from_value(json!({ "machine": null, "train": ["run.csv"],
            "maps": ["time=Zeit [s]"], "unused": ["command [V]"] }))
            .unwrap(),
        )
        .unwrap();
        assert_eq!(before_there_is_a_machine["files"][0]["columns"][2]["unused"], true);
    }

    #[test]
    fn what_is_mapped_by_hand_is_read_from_the_machine_file_from_then_on() {
        let text = written(&request(r#"["time=Zeit [s]", "position=Kolbenweg [mm]"]"#)).unwrap();
        let file = machine_file::read_text("machine.toml", &text).unwrap();
        let read = recording::read_from("run.csv", desk().bytes("run.csv").unwrap(), &file.channels).unwrap();
        assert!(read.has(Signal::Position) && read.has(Signal::Command));
        assert!(written(&request(r#"["weg=Kolbenweg [mm]"]"#)).is_err());
    }
}
