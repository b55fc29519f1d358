//! Every paragraph, list item and row of docs/formats.md, held by a check.

use std::fs;
use std::path::Path;

use recording::{ChannelMap, Recording, Signal, guess, read_from, survey_from};

use crate::{commands, damaged, fixture, fixtures, others, written};

/// Words of the chapter, and what holds them.
type Claim = (&'static str, fn());

fn chapter() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md")).unwrap()
}

fn reads(text: impl AsRef<[u8]>) -> Recording {
    reads_mapped(text, &[])
}

#[track_caller]
fn reads_mapped(text: impl AsRef<[u8]>, maps: &[&str]) -> Recording {
    let maps = ChannelMap::from_arguments(maps.iter().copied()).unwrap();
    read_from("run.csv", text.as_ref(), &maps).unwrap_or_else(|error| panic!("{error}"))
}

/// What is said of a text that is refused.
#[track_caller]
fn refused(text: impl AsRef<[u8]>) -> String {
    read_from("run.csv", text.as_ref(), &ChannelMap::default()).unwrap_err().to_string()
}

#[track_caller]
fn positions(text: &str, expected: &[f64]) {
    assert_eq!(reads(text).signal(Signal::Position).unwrap(), expected, "{text}");
}

#[track_caller]
fn times(text: &str, expected: &[f64]) {
    let found = reads(text).time_s().to_vec();
    let off = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max);
    assert!(found.len() == expected.len() && off < 1e-9, "{text}: {found:?}");
}

#[track_caller]
fn notes(text: impl AsRef<[u8]>) -> String {
    let notes = reads(text);
    notes.notes().iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// The rows of the table of names: names and units.
fn named() -> Vec<(Vec<String>, Vec<String>)> {
    let chapter = chapter();
    let (_, table) = chapter.split_once("| names | units |\n|---|---|\n").unwrap();
    let words = |cell: &str| cell.split_whitespace().map(|word| word.trim_matches('`').to_owned()).collect();
    let rows = table.lines().take_while(|line| line.starts_with('|')).map(|line| {
        let cells: Vec<&str> = line.split('|').collect();
        (words(cells[1]), words(cells[2]))
    });
    rows.collect()
}

fn every_name_has_every_unit_of_its_row() {
    let rows = named();
    assert_eq!(rows.len(), 12);
    for (names, units) in rows {
        for name in &names {
            assert!(Signal::parse(name).is_some(), "{name}");
            for unit in &units {
                let text = if name == "time" {
                    format!("time [{unit}],position [m]\n0,0\n1,1\n")
                } else {
                    format!("time [s],{name} [{unit}]\n0,1\n1,2\n")
                };
                assert!(reads(&text).has(Signal::parse(name).unwrap()), "{text}");
            }
        }
    }
    assert!(refused("time [s],position [bar]\n0,1\n1,2\n").contains("bar"));
}

fn a_unit_stands_in_brackets_or_another_known_way() {
    for header in ["position [mm]", "position (mm)", "position/mm", "position in mm"] {
        positions(&format!("time [s],{header}\n0,1\n1,2\n"), &[1e-3, 2e-3]);
    }
    for unit in ["sec", "s"] {
        positions(
            &format!("time [{unit}],position [mm],flow [L/min],pump_speed [1/min],angle [°]\n0,1,1,1,1\n1,2,1,1,1\n"),
            &[1e-3, 2e-3],
        );
    }
}

fn a_dimensionless_signal_needs_no_unit() {
    for header in ["spool", "spool [-]", "spool (-)", "spool/1"] {
        let text = format!("time [s],{header}\n0,0.5\n1,0.25\n");
        assert_eq!(reads(text).signal(Signal::Spool).unwrap(), [0.5, 0.25], "{header}");
    }
    assert!(refused("time [s],position (-)\n0,0.5\n1,0.25\n").contains("`-`"));
}

fn other_names_are_mapped() {
    let text = "time [s],Kolbenweg [mm],Kolbenweg_mm\n0,1,3\n1,2,4\n";
    for (map, first) in [("position=Kolbenweg [mm]", 1e-3), ("position=Kolbenweg_mm [mm]", 3e-3)] {
        assert_eq!(reads_mapped(text, &[map]).signal(Signal::Position).unwrap(), [first, first + 1e-3], "{map}");
    }
    let known = "time [s],position [mm],x [mm]\n0,1,3\n1,2,4\n";
    assert_eq!(reads_mapped(known, &["position=x [mm]"]).signal(Signal::Position).unwrap(), [3e-3, 4e-3]);
    let ignored = reads(known);
    assert_eq!(ignored.ignored(), ["x [mm]"]);
}

fn a_line_of_channels_for_a_column_that_is_not_there_does_nothing() {
    let preset = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../presets/press-63-40.toml")).unwrap();
    let file = machine_file::read_text("m.toml", &format!("{preset}\n[channels]\nposition = \"Weg [mm]\"\n")).unwrap();
    let read = |text: &str| read_from("run.csv", text.as_bytes(), &file.channels).unwrap();
    assert_eq!(read("time [s],position [mm]\n0,1\n1,2\n").signal(Signal::Position).unwrap(), [1e-3, 2e-3]);
    assert_eq!(read("time [s],Weg [mm]\n0,1\n1,2\n").signal(Signal::Position).unwrap(), [1e-3, 2e-3]);
}

fn a_column_in_an_unknown_unit_is_left_out_as_the_error_says() {
    let text = "time [s],position [mm],oil_temperature [degF]\n0,1,70\n1,2,70\n";
    let remedy = "unused = [\"oil_temperature [degF]\"]";
    assert!(refused(text).contains(remedy), "{}", refused(text));
    let preset = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../presets/press-63-40.toml")).unwrap();
    let file = machine_file::read_text("m.toml", &format!("{preset}\n[channels]\n{remedy}\n")).unwrap();
    assert_eq!(read_from("run.csv", text.as_bytes(), &file.channels).unwrap().rows(), 2);
}

fn a_block_is_guessed_where_no_column_is_known() {
    let row = |row: i32| format!("{},{},{}", f64::from(row) * 0.01, row % 7, 100 + row);
    let rows = (0..200).map(row).collect::<Vec<_>>().join("\n");
    let columns = survey_from("run.csv", format!("Zeit [s],Spannung [V],Weg [mm]\n{rows}").as_bytes()).unwrap();
    let block = guess::block(&columns);
    assert!(block.contains("[channels]") && block.contains("Weg"), "{block}");
}

fn a_written_file_reads_back_with_the_same_map() {
    let folder = tempfile::tempdir().unwrap();
    let map = ["position=Kolbenweg [mm]"];
    let recording = reads_mapped("time [s],Kolbenweg [mm]\n0,1\n1,2.5\n", &map);
    let path = folder.path().join("again.csv");
    recording.write(&path, &[], &[]).unwrap();
    let again = recording::read(&path, &ChannelMap::from_arguments(map).unwrap()).unwrap();
    assert_eq!(again.signal(Signal::Position), recording.signal(Signal::Position));
}

fn an_angle_becomes_the_position_only_with_a_linkage() {
    let text = "time [s],angle [deg]\n0,10\n1,11\n";
    let found = reads(text);
    assert!(!found.has(Signal::Position) && found.has(Signal::Angle));
    let beside = reads("time [s],angle [deg],position [mm]\n0,10,1\n1,11,2\n");
    assert_eq!(beside.signal(Signal::Position).unwrap(), [1e-3, 2e-3]);
}

fn time_is_found_anywhere_and_never_an_index() {
    let found = reads(",position [mm],time [s]\n0,1,0\n1,2,0.5\n");
    assert_eq!(found.time_s(), [0.0, 0.5]);
    assert_eq!(found.columns()[0].signal, Signal::Time);
    for index in ["", "index", "Unnamed: 0", "Nr."] {
        let maps = ChannelMap::from_arguments([format!("time={index} [s]").as_str()]);
        let text = format!("{index},position [mm]\n0,1\n1,2\n2,3\n");
        let taken = maps.ok().and_then(|maps| read_from("run.csv", text.as_bytes(), &maps).ok());
        assert!(taken.is_none(), "{index}");
    }
}

fn a_value_that_is_none_leaves_its_row_out() {
    for none in ["", "NaN", "nan", "NA", "n/a", "#N/A", "None", "1.#QNAN"] {
        let text = format!("time [s],position [mm]\n0,1\n1,{none}\n2,3\n");
        positions(&text, &[1e-3, 3e-3]);
        assert!(notes(&text).contains("left out"), "{none}");
    }
    assert!(refused("time [s],position [mm]\n0,1\n1,inf\n").contains("inf"));
    assert!(refused("time [s],position [mm]\n0,1\n1,high\n").contains("high"));
}

fn the_encoding_is_utf_8_utf_16_or_windows_1252() {
    positions("\u{feff}time [s],position [mm]\n0,1\n1,2\n", &[1e-3, 2e-3]);
    let western = b"time [s],position [mm],Druck R\xfccklauf [bar]\n0,1,2\n1,2,2\n";
    let found = reads(western);
    assert!(found.ignored()[0].starts_with("Druck Rücklauf"));
    assert!(notes(western).contains("Windows-1252") && notes(western).contains("line 1"), "{}", notes(western));
    // As Excel writes it, and the other order of bytes; a header that is longer than a reader's buffer.
    let text = format!("\u{feff}time [s]\tposition [mm]\tVentil {}\n0\t1,5\tµ\n1\t2,5\tö\n", "ü".repeat(9000));
    for order in [u16::to_le_bytes, u16::to_be_bytes] {
        let wide: Vec<u8> = text.encode_utf16().flat_map(order).collect();
        assert_eq!(reads(&wide).signal(Signal::Position).unwrap(), [1.5e-3, 2.5e-3]);
        assert_eq!(survey_from("run.txt", wide.as_slice()).unwrap().len(), 3);
    }
    for order in [u16::to_le_bytes, u16::to_be_bytes] {
        let unmarked = |text: &str| text.encode_utf16().flat_map(order).collect::<Vec<u8>>();
        assert_eq!(
            reads(unmarked("time [s],position [mm]\n0,1\n1,2\n")).signal(Signal::Position).unwrap(),
            [1e-3, 2e-3]
        );
        assert!(refused(unmarked("Weg ü,time [s],position [mm]\n0,0,1\n")).contains("UTF-8"));
    }
}

fn the_separator_is_the_first_of_the_header_or_what_sep_says() {
    for text in [
        "time [s],position [mm]\n0,1\n1,2\n",
        "time [s];position [mm]\n0;1\n1;2\n",
        "time [s]\tposition [mm]\n0\t1\n1\t2\n",
        "sep=;\ntime [s];position [mm]\n0;1\n1;2\n",
        "time [s]|position [mm]\n0|1\n1|2\n",
        "sep=:\ntime [s]:position [mm]\n0:1\n1:2\n",
        "time [s],position [mm],\n0,1,\n1,2,\n",
        "# made by hand\n\ntime [s],position [mm]\n0,1\n# between\n\n1,2\n",
        "# made by hand\n# time [s],position [mm]\n0,1\n1,2\n",
        "time [s]|Druck, links [bar]|position [mm]\n0|5|1\n1|5|2\n",
        "time [s],position [mm]\n0,1\n#N/A,5\n1,2\n",
    ] {
        positions(text, &[1e-3, 2e-3]);
    }
    assert!(refused("time [s]  position [mm]\n0  1\n1  2\n").contains("separated by blanks"));
}

fn words_below_the_rows_are_none() {
    for words in ["End of file", "Average,1.5"] {
        let text = format!("time [s],position [mm]\n0,1\n1,2\n{words}\n");
        positions(&text, &[1e-3, 2e-3]);
        assert!(notes(&text).contains("line 4, the last one"), "{}", notes(&text));
        assert!(refused(format!("{text}Max,2\n")).contains("run.csv:4:1"));
    }
}

fn two_columns_of_one_name_are_refused() {
    assert!(refused("time [s],position [mm],position [mm]\n0,1,2\n1,2,3\n").contains("columns 2 and 3"));
    let map = ChannelMap::from_arguments(["position=Weg [mm]"]).unwrap();
    let mapped = read_from("run.csv", &b"time [s],Weg [mm],Weg [mm]\n0,1,2\n1,2,3\n"[..], &map).unwrap_err();
    assert!(mapped.to_string().contains("columns 2 and 3"), "{mapped}");
}

fn the_decimal_mark_is_one_for_the_whole_file() {
    positions("time [s];position [mm]\n0,5;1,5\n1,5;2,5\n", &[1.5e-3, 2.5e-3]);
    let both = refused("time [s];position [mm]\n0;1,5\n1;2.5\n");
    assert!(both.contains("1,5") && both.contains("2.5"), "{both}");
    for thousands in ["1.234,5", "1 300"] {
        refused(format!("time [s];position [mm]\n0;{thousands}\n1;2\n"));
    }
    refused("time [s];position [mm]\n0;1.300\n1;1.400\n");
    positions("time [s],position [mm]\n0,1.300\n1,1.400\n", &[1.3e-3, 1.4e-3]);
    positions("time [s];position [mm]\n0.002;1.300\n1.002;1.400\n", &[1.3e-3, 1.4e-3]);
}

fn units_stand_in_a_row_below_the_header() {
    for row in ["s,mm", "[s],[mm]"] {
        positions(&format!("time,position\n{row}\n0,1\n1,2\n"), &[1e-3, 2e-3]);
        positions(&format!("time [s],position [mm]\n{row}\n0,1\n1,2\n"), &[1e-3, 2e-3]);
    }
    let told = refused("time [s],position [mm]\ns,cm\n0,1\n1,2\n");
    assert!(told.contains("`mm`") && told.contains("`cm`"), "{told}");
    let map = ChannelMap::from_arguments(["position=position_mm"]).unwrap();
    assert!(read_from("run.csv", &b"time [s],position_mm\ns,cm\n0,1\n1,2\n"[..], &map).is_err());
}

fn dates_and_durations_are_times() {
    for (first, second) in [
        ("2024-05-06T07:08:09.125", "2024-05-06T07:08:09.625"),
        ("2024-05-06 07:08:09.125", "2024-05-06 07:08:09.625"),
        ("2024-05-06T07:08:09.125Z", "2024-05-06T07:08:09.625Z"),
        ("06.05.2024 07:08:09.125", "06.05.2024 07:08:09.625"),
        ("07:08:09.125", "07:08:09.625"),
        ("0 days 00:00:00.125", "0 days 00:00:00.625"),
        ("PT0.125S", "PT0.625S"),
    ] {
        times(&format!("time,position [mm]\n{first},1\n{second},2\n"), &[0.0, 0.5]);
    }
    times("time;position [mm]\n06.05.2024 07:08:09,125;1\n06.05.2024 07:08:09,625;2\n", &[0.0, 0.5]);
    for unread in ["5/6/2024 07:08:09", "10:00:00 PM", "10:00", "05-06-24 07:08:09", "5/6/24 07:08:09"] {
        let told = refused(format!("time,position [mm]\n{unread},1\n{unread},2\n"));
        assert!(told.contains(unread) && told.contains("2024-05-06T07:08:09.125"), "{told}");
    }
    times("time,position [mm]\n23:59:59.75,1\n00:00:00.25,2\n", &[0.0, 0.5]);
    assert!(refused("time,position [mm]\n10:00:01,1\n10:00:00,2\n").contains("rise"));
}

fn a_last_line_that_is_cut_off_is_not_read() {
    let cut = "time [s],position [mm],command [V]\n0,1,1.25\n1,2,1.25\n2,3";
    assert_eq!(reads(cut).rows(), 2);
    assert!(!notes(cut).is_empty());
    assert_eq!(reads("time [s],position [mm]\n0,1.125\n1,2.125\n2,3.1").rows(), 2);
    assert_eq!(reads("time [s],position [mm]\n0,1.125\n1,2.125\n2,3.125").rows(), 3);
}

fn a_scale_of_a_scope_header_is_doubted() {
    let text = fs::read_to_string(fixture("scope.txt")).unwrap();
    let with_factor = |line: &str| {
        let cell = |cell: &str| if cell.starts_with("SampleTime") { "ScaleFactor" } else { "2" };
        let factors = line.split('\t').map(cell).collect::<Vec<_>>().join("\t");
        if line.starts_with("SampleTime") { format!("{line}\n{factors}\n") } else { format!("{line}\n") }
    };
    let scaled: String = text.lines().map(with_factor).collect();
    assert!(!notes(&text).contains("scale factor") && notes(&scaled).contains("scale factor"), "{}", notes(&scaled));
    assert_eq!(reads(&scaled).signal(Signal::Position), reads(&text).signal(Signal::Position));
}

fn rows_and_columns_have_a_limit() {
    let header = (0..5000).map(|column| format!("c{column}")).collect::<Vec<_>>().join(",");
    refused(format!("time [s],position [mm],{header}\n0,1{}\n", ",0".repeat(5000)));
}

fn control_characters_of_a_file_are_spelt_out() {
    let said = refused("time [s],posi\u{1b}[31mtion [furlong]\n0,1\n");
    assert!(
        !said.contains('\u{1b}') || recording::files::source_error::printable(&said).contains("\\u{1b}"),
        "{said:?}"
    );
}

/// By the beginning of each paragraph, list item and row of a table, in the chapter's order.
const CLAIMS: &[Claim] = &[
    ("The format is found by a file's content", fixtures::every_format_gives_the_recording_of_the_csv),
    ("| CSV (also", the_separator_is_the_first_of_the_header_or_what_sep_says),
    ("| TwinCAT Scope, text export", fixtures::every_format_gives_the_recording_of_the_csv),
    ("| Excel workbook", fixtures::every_format_gives_the_recording_of_the_csv),
    ("| MATLAB MAT-file", written::what_is_written_reads_back_in_every_format),
    ("| ASAM MDF 4", fixtures::every_format_gives_the_recording_of_the_csv),
    ("| Apache Parquet", written::what_is_written_reads_back_in_every_format),
    ("| any of these packed by gzip", fixtures::every_format_gives_the_recording_of_the_csv),
    ("`simulate --out` chooses the format", commands::a_simulation_is_written_in_the_format_of_its_name),
    ("`simulate --out` chooses the format", commands::a_folder_may_hold_recordings_of_every_format_but_each_once),
    ("A file of another kind says what it is", damaged::files_of_other_versions_say_how_to_save_them),
    ("A column is a signal when", every_name_has_every_unit_of_its_row),
    ("| `time` |", every_name_has_every_unit_of_its_row),
    ("| `command` |", every_name_has_every_unit_of_its_row),
    ("| `spool` ", every_name_has_every_unit_of_its_row),
    ("| `flow` ", every_name_has_every_unit_of_its_row),
    ("| `pump_speed` |", every_name_has_every_unit_of_its_row),
    ("| `pressure_a` ", every_name_has_every_unit_of_its_row),
    ("| `force` ", every_name_has_every_unit_of_its_row),
    ("| `position` |", every_name_has_every_unit_of_its_row),
    ("| `velocity` |", every_name_has_every_unit_of_its_row),
    ("| `angle` |", every_name_has_every_unit_of_its_row),
    ("| `reference` |", every_name_has_every_unit_of_its_row),
    ("| `oil_temperature` |", every_name_has_every_unit_of_its_row),
    ("The unit stands", a_unit_stands_in_brackets_or_another_known_way),
    ("1. in brackets", a_unit_stands_in_brackets_or_another_known_way),
    ("2. beside the name", units_stand_in_a_row_below_the_header),
    ("2. beside the name", fixtures::units_are_those_of_the_file),
    ("3. behind an underscore", fixtures::units_are_those_of_the_file),
    ("A dimensionless signal", a_dimensionless_signal_needs_no_unit),
    ("A dimensionless signal", a_column_in_an_unknown_unit_is_left_out_as_the_error_says),
    ("A dimensionless signal", other_names_are_mapped),
    ("A dimensionless signal", fixtures::every_format_is_mapped),
    ("A dimensionless signal", a_line_of_channels_for_a_column_that_is_not_there_does_nothing),
    ("A dimensionless signal", a_block_is_guessed_where_no_column_is_known),
    ("A dimensionless signal", fixtures::what_is_no_signal_is_ignored_by_its_name),
    ("A dimensionless signal", a_written_file_reads_back_with_the_same_map),
    ("`angle` is that of the joint", an_angle_becomes_the_position_only_with_a_linkage),
    ("Time is found in any column", time_is_found_anywhere_and_never_an_index),
    ("A value that is NaN", a_value_that_is_none_leaves_its_row_out),
    ("A value that is NaN", written::what_was_left_out_is_written_as_no_value),
    ("- **Encoding**", the_encoding_is_utf_8_utf_16_or_windows_1252),
    ("- **Separator**", the_separator_is_the_first_of_the_header_or_what_sep_says),
    ("- **Decimal mark**", the_decimal_mark_is_one_for_the_whole_file),
    ("- **Units** may stand", units_stand_in_a_row_below_the_header),
    ("- **Dates**", dates_and_durations_are_times),
    ("- **A last line", a_last_line_that_is_cut_off_is_not_read),
    ("- **Words below the rows**", words_below_the_rows_are_none),
    ("- **Two columns of one name**", two_columns_of_one_name_are_refused),
    ("TwinCAT Scope: where the header", a_scale_of_a_scope_header_is_doubted),
    ("The sheet is read as text", fixtures::every_format_gives_the_recording_of_the_csv),
    ("- **Vectors**", fixtures::what_is_not_read_says_what_to_do),
    ("- **A structure of vectors**", fixtures::every_format_is_mapped),
    ("- **A structure with `Time` and `Data`**", fixtures::every_format_gives_the_recording_of_the_csv),
    ("- **Simulink's", fixtures::every_format_gives_the_recording_of_the_csv),
    ("- **ControlDesk's", fixtures::every_format_gives_the_recording_of_the_csv),
    ("A matrix is not a signal", fixtures::what_is_not_read_says_what_to_do),
    ("A matrix is not a signal", damaged::files_of_other_versions_say_how_to_save_them),
    ("A matrix is not a signal", others::scipy_reads_a_mat_file_that_is_written),
    ("The master channel", fixtures::channels_of_another_group_are_interpolated),
    ("The master channel", fixtures::the_members_of_a_structure_and_the_elements_of_an_array_are_channels),
    ("The master channel", fixtures::a_text_among_the_numbers_of_a_channel_is_an_empty_cell),
    ("Flat columns of numbers", fixtures::timestamps_count_from_the_first),
    ("Flat columns of numbers", fixtures::durations_and_old_timestamps_are_in_seconds_whatever_their_names_say),
    ("Flat columns of numbers", fixtures::a_null_is_an_empty_cell),
    ("Flat columns of numbers", others::pyarrow_reads_a_parquet_file_that_is_written),
    ("| rows, columns |", rows_and_columns_have_a_limit),
    ("| what is compressed", damaged::what_unpacks_to_too_much_is_refused_before_it_is_unpacked),
    ("**Whole files.**", written::a_file_that_cannot_be_written_leaves_the_old_one),
    ("**Whole files.**", damaged::a_file_that_is_cut_is_refused_or_lacks_what_is_not_there),
    ("A MAT-file has no end mark", damaged::flipped_bits_make_an_error_or_a_recording),
    ("Names come from files", control_characters_of_a_file_are_spelt_out),
];

/// What tests of other folders hold, or what no file could show, and why.
const ELSEWHERE: [(&str, &str); 8] = [
    ("- The model's step", "the parts of a long text: host-sim/tests/cli/simulate.rs"),
    ("- Failures and noise", "the same"),
    ("- A row without a value", "the same"),
    ("**Longer texts.**", "the same"),
    ("| values of known columns |", "a file of gigabytes"),
    ("| a file that is not text |", "a file of gigabytes"),
    ("| recorder frames |", "host-sim/tests/cli/import.rs"),
    ("A recording is held in memory", "a recording of gigabytes"),
];

/// Paragraphs, list items and rows of tables, each in one line.
fn parts() -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    let mut goes_on = false;
    for line in chapter().lines() {
        let text = line.trim();
        let is_item = text.starts_with("- ")
            || text.starts_with('|')
            || text.split_once(". ").is_some_and(|(n, _)| n.parse::<u8>().is_ok());
        let is_frame = text.is_empty() || text.starts_with('#') || text.starts_with("|---");
        match parts.last_mut() {
            Some(last) if goes_on && !is_item && !is_frame => *last = format!("{last} {text}"),
            _ if !is_frame => parts.push(text.to_owned()),
            _ => {}
        }
        goes_on = !is_frame && !text.starts_with('|');
    }
    let heads = ["| Format |", "| names |", "| limit |"];
    parts.retain(|part| !heads.iter().any(|head| part.starts_with(head)));
    parts
}

#[test]
fn every_line_of_the_chapter_is_held_by_a_check() {
    let parts = parts();
    assert!(parts.len() > 55, "{}", parts.len());
    let begins: Vec<&str> =
        CLAIMS.iter().map(|(begins, _)| *begins).chain(ELSEWHERE.map(|(begins, _)| begins)).collect();
    for part in &parts {
        assert!(begins.iter().any(|begins| part.starts_with(begins)), "no check holds: {part}");
    }
    for begins in begins {
        assert!(parts.iter().any(|part| part.starts_with(begins)), "the chapter has no longer: {begins}");
    }
    let mut held: Vec<fn()> = Vec::new();
    for (_, holds) in CLAIMS {
        if !held.iter().any(|known| std::ptr::fn_addr_eq(*known, *holds)) {
            held.push(*holds);
            holds();
        }
    }
}
