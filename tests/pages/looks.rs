//! The pages to look at before anything is searched: of an inspection, a comparison and a fit.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use clap::Parser;
use tempfile::TempDir;

use host_sim::cli::{self, Cli, Console};

use super::chromium::{Chromium, program};

const ALL: [&str; 3] = ["inspect.html", "compare.html", "fit.html"];
const OVER_TIME: &str = "window.hostSimCharts.find(one => one.kind === 'time')";

/// The folder with the three pages, of the shipped press; what is inspected has a gap, a spike, and a channel that the model does not know.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    FOLDER
        .get_or_init(|| {
            let folder = tempfile::tempdir().unwrap();
            let example = |name: &str| {
                Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/press-63-40").join(name).display().to_string()
            };
            let at = |name: &str| folder.path().join(name).display().to_string();
            std::fs::write(at("odd.csv"), odd(&std::fs::read_to_string(example("train-1.csv")).unwrap())).unwrap();
            let machine = std::fs::read_to_string(example("machine.toml")).unwrap();
            let soft = machine.replace("bulk_modulus_pa = 1.2e9", "bulk_modulus_pa = 0.8e9");
            assert_ne!(soft, machine);
            std::fs::write(at("soft.toml"), soft).unwrap();
            let (drive, train, holdout) = (example("machine.toml"), example("train-1.csv"), example("holdout-1.csv"));
            let (odd, soft) = (at("odd.csv"), at("soft.toml"));
            for (page, arguments) in [
                (ALL[0], vec!["inspect", &odd, &train, "--machine", &drive]),
                (ALL[1], vec!["compare", &holdout, &train, "--machine", &drive, "--machine", &soft]),
                (ALL[2], vec!["fit", &train, "--machine", &soft, "--holdout", &holdout]),
            ] {
                let report = at(page);
                let words = [&["host-sim"], arguments.as_slice(), &["--report", &report]].concat();
                let cli = Cli::try_parse_from(words).unwrap();
                cli::run(&cli.command, &mut Console::into_buffer(&mut Vec::new())).unwrap();
            }
            folder
        })
        .path()
}

/// A recording without rows 700 to 759, with a spike in row 300 and one column more.
fn odd(text: &str) -> String {
    let (header, rows) = text.split_once('\n').unwrap();
    let position = header.split(',').position(|name| name.starts_with("position")).unwrap();
    let mut odd = format!("{header},Motorstrom [A]\n");
    for (row, line) in rows.lines().enumerate().filter(|(row, _)| !(700..760).contains(row)) {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if row == 300 {
            cells[position] = (1.5 * cells[position].parse::<f64>().unwrap()).to_string();
        }
        cells.push((row % 100).to_string());
        odd += &cells.join(",");
        odd.push('\n');
    }
    odd
}

fn page(name: &str) -> PathBuf {
    folder().join(name)
}

/// A page in a browser, where there is one.
fn opened(name: &str) -> Option<Chromium> {
    let mut browser = Chromium::start(&program()?);
    browser.open(&page(name));
    browser.until("window.hostSimCharts.length > 3");
    Some(browser)
}

fn texts(browser: &mut Chromium, selector: &str) -> Vec<String> {
    let found = browser.value(&format!("[...document.querySelectorAll('{selector}')].map(one => one.textContent)"));
    found.as_array().unwrap().iter().map(|text| text.as_str().unwrap().to_owned()).collect()
}

fn unfold(browser: &mut Chromium) {
    browser.value("document.querySelectorAll('details').forEach(folded => folded.open = true)");
    browser.until("document.querySelectorAll('figure.data:not(.live)').length === 0");
}

#[test]
fn each_page_draws_without_a_complaint_and_asks_nothing_of_the_network() {
    for name in ALL {
        let Some(mut browser) = opened(name) else { return };
        unfold(&mut browser);
        let drawn = "window.hostSimCharts.every(one => one.plot.ctx.canvas.width > 0 && one.plot.data[0].length > 1)";
        assert_eq!(browser.value(drawn), true, "{name}");
        assert_eq!(browser.complaints(), Vec::<serde_json::Value>::new(), "{name}");
        assert_eq!(browser.requests(&page(name)), Vec::<String>::new(), "{name}");
        let bytes = std::fs::metadata(page(name)).unwrap().len();
        assert!(bytes < 3_000_000, "{name}: {bytes} bytes");
    }
}

#[test]
fn dragging_zooms_every_chart_of_a_recording_and_a_double_click_shows_all_again() {
    for name in ALL {
        let Some(mut browser) = opened(name) else { return };
        browser.value(&format!("{OVER_TIME}.plot.root.scrollIntoView({{ block: 'center' }})"));
        let place = browser.value(&format!(
            "(() => {{ const box = {OVER_TIME}.plot.over.getBoundingClientRect(); return [box.left, box.top, box.width, box.height]; }})()"
        ));
        let [left, top, width, height] = [0, 1, 2, 3].map(|index| place[index].as_f64().unwrap());
        let last = browser.value(&format!("{OVER_TIME}.plot.scales.x.max")).as_f64().unwrap();
        browser.drag((left + 0.25 * width, top + 0.5 * height), (left + 0.5 * width, top + 0.5 * height));
        browser.until(&format!("Math.abs({OVER_TIME}.plot.scales.x.max - {}) < {}", 0.5 * last, 0.05 * last));
        let max = browser.value(&format!("{OVER_TIME}.plot.scales.x.max"));
        browser.until(&format!(
            "window.hostSimCharts.filter(one => one.figure === {OVER_TIME}.figure).every(one => one.plot.scales.x.max === {max})"
        ));
        browser.click((left + 0.5 * width, top + 0.5 * height), 2);
        browser.until(&format!("{OVER_TIME}.plot.scales.x.max === {last}"));
        // The same by keys.
        let key = |key: &str| {
            format!(
                "{OVER_TIME}.figure.querySelector('.plots').dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}' }}))"
            )
        };
        browser.value(&key("+"));
        browser.until(&format!("Math.abs({OVER_TIME}.plot.scales.x.max - {}) < {}", 0.75 * last, 0.01 * last));
        browser.value(&key("ArrowRight"));
        browser.until(&format!("{OVER_TIME}.plot.scales.x.max > {}", 0.85 * last));
        browser.value(&key("0"));
        browser.until(&format!("{OVER_TIME}.plot.scales.x.max === {last} && {OVER_TIME}.plot.scales.x.min === 0"));
    }
}

#[test]
fn a_finger_that_moves_sideways_zooms() {
    let Some(mut browser) = opened(ALL[0]) else { return };
    let moved = format!(
        "(() => {{ const over = {OVER_TIME}.plot.over, box = over.getBoundingClientRect();
            const at = (type, share) => over.dispatchEvent(new PointerEvent(type, {{ pointerType: 'touch', bubbles: true,
                clientX: box.left + share * box.width, clientY: box.top + 20 }}));
            at('pointerdown', 0.2); at('pointermove', 0.5); at('pointerup', 0.6); }})()"
    );
    let last = browser.value(&format!("{OVER_TIME}.plot.scales.x.max")).as_f64().unwrap();
    browser.value(&moved);
    browser.until(&format!("Math.abs({OVER_TIME}.plot.scales.x.max - {}) < {}", 0.6 * last, 0.02 * last));
    browser.until(&format!("Math.abs({OVER_TIME}.plot.scales.x.min - {}) < {}", 0.2 * last, 0.02 * last));
}

#[test]
fn a_trace_that_is_switched_off_moves_no_axis() {
    for name in &ALL[1..] {
        let Some(mut browser) = opened(name) else { return };
        // The chart in which a simulation goes furthest beyond all others.
        let with_two = "window.hostSimCharts.filter(one => one.kind === 'time' && one.plot.series.length > 3)";
        let ends = format!("JSON.stringify({with_two}.map(one => [one.plot.scales.y.min, one.plot.scales.y.max]))");
        let before = browser.value(&ends);
        assert_ne!(before, "[]", "{name}");
        for trace in [1, 2, 3] {
            browser.value(&format!("{with_two}.forEach(one => one.plot.setSeries({trace}, {{ show: false }}))"));
            browser.until(&format!("{with_two}.every(one => !one.plot.series[{trace}].show)"));
            assert_eq!(browser.value(&ends), before, "{name}, trace {trace}");
        }
        // A part of the time has limits of its own.
        browser.value(&format!("{OVER_TIME}.plot.setScale('x', {{ min: 0.1, max: 0.4 }})"));
        browser.until(&format!("{ends} !== {before}"));
    }
}

#[test]
fn nothing_is_wider_than_a_phone() {
    for name in ALL {
        let Some(mut browser) = opened(name) else { return };
        browser.resize(375, 812, true);
        browser.open(&page(name));
        browser.until("window.hostSimCharts.length > 3");
        unfold(&mut browser);
        let widest = "[...document.querySelectorAll('body *')].filter(part => part.getBoundingClientRect().right > 376 && \
            !part.closest('table, pre, figure')).map(part => part.tagName + ' ' + part.className).slice(0, 5)";
        let width = browser.value("document.documentElement.scrollWidth");
        assert_eq!(width, 375, "{name}: {}", browser.value(widest));
        let charts = "window.hostSimCharts.every(one => one.plot.root.getBoundingClientRect().right <= 375)";
        assert_eq!(browser.value(charts), true, "{name}");
    }
}

#[test]
fn an_inspection_shows_every_channel_and_marks_what_is_suspicious() {
    let Some(mut browser) = opened(ALL[0]) else { return };
    let data = browser.value("JSON.parse(document.querySelector('figure.data script').textContent)");
    let panels = data["panels"].as_array().unwrap();
    let titles: Vec<&str> = panels.iter().map(|panel| panel["title"].as_str().unwrap()).collect();
    assert_eq!(titles, ["Command", "Spool", "Position", "Pressure A", "Pressure B", "Motorstrom"]);
    // The gap in every chart, the spike in its own.
    let shades = |panel: &serde_json::Value| panel["shade"].as_array().unwrap().len();
    assert_eq!(panels.iter().map(shades).collect::<Vec<_>>(), [1, 1, 2, 1, 1, 1]);
    assert!(panels[2]["note"].as_str().unwrap().starts_with("a spike at 0.600 s, to "), "{}", panels[2]["note"]);
    assert_eq!(panels[5]["note"], "no known signal: the model does not use it");
    let said = texts(&mut browser, "ul.remark li");
    assert!(said.iter().any(|said| said.starts_with("position: a spike at 0.600 s")), "{said:?}");
    assert!(said.iter().any(|said| said.contains("1 gap in time")), "{said:?}");
    let links = texts(&mut browser, ".links tr");
    assert!(links.len() == 5 && links[0] == "● valvealone: driven by the command, judged by spool", "{links:?}");
    assert_eq!(texts(&mut browser, "h2"), ["What can be tested", "odd.csv", "train-1.csv"]);
}

#[test]
fn a_comparison_shows_each_part_of_the_chain_with_every_machine_file() {
    let Some(mut browser) = opened(ALL[1]) else { return };
    let headings = texts(&mut browser, "h2");
    let expected = [
        "Every part",
        "End to end",
        "Link: valve",
        "Links below the spool",
        "Links: flow and chambers",
        "Link: mechanics",
        "Are the residuals white?",
    ];
    assert_eq!(headings, expected);
    let data = browser.value("JSON.parse(document.querySelector('figure.data script').textContent)");
    let labels: Vec<&str> =
        data["panels"][2]["traces"].as_array().unwrap().iter().map(|trace| trace["label"].as_str().unwrap()).collect();
    assert_eq!(labels, ["recorded", "machine", "soft"]);
    let doubts = texts(&mut browser, "section .fact");
    assert!(doubts.iter().any(|doubt| doubt.contains("cannot be judged by position")), "{doubts:?}");
    assert!(texts(&mut browser, "h1")[0].starts_with("machine fits best end to end in "));
}

#[test]
fn a_fit_shows_its_values_and_what_they_are_worth_on_held_out_recordings() {
    let Some(mut browser) = opened(ALL[2]) else { return };
    let headings = texts(&mut browser, "h2");
    let expected = ["Values", "Before and after", "Every recording", "Is the residual white?"];
    assert_eq!(headings.iter().filter(|heading| expected.contains(&heading.as_str())).count(), 4, "{headings:?}");
    let parameters = texts(&mut browser, "section:first-of-type td:first-child");
    assert!(parameters.iter().any(|name| name == "cylinder.bulk_modulus_pa"), "{parameters:?}");
    let rows = texts(&mut browser, "td:first-child");
    assert!(rows.iter().any(|row| row == "held out · pressure A"), "{rows:?}");
    let open = texts(&mut browser, "details[open] > summary");
    assert!(open.len() == 1 && open[0].starts_with("holdout-1.csv (held out)"), "{open:?}");
}
