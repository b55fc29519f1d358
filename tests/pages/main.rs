//! Is a page usable for a person? Tested in a real browser: it draws, requests nothing from the network,
//! and works on a phone, in dark mode and in a browser without scripts.

mod chromium;
mod looks;
mod studio;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use chromium::{Chromium, program};
use clap::Parser;
use tempfile::TempDir;

use host_sim::cli::{self, Cli, Console};

/// The page of the shipped example.
fn page() -> &'static Path {
    static PAGE: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, page) = PAGE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("press.html");
        let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/press-63-40");
        let arguments = ["host-sim", "diagnose", example.to_str().unwrap(), "--report", page.to_str().unwrap()];
        let cli = Cli::try_parse_from(arguments).unwrap();
        let mut printed = Vec::new();
        cli::run(&cli.command, &mut Console::into_buffer(&mut printed)).unwrap();
        (folder, page)
    });
    page
}

/// The page in a browser, where there is one.
fn opened() -> Option<Chromium> {
    let mut browser = Chromium::start(&program()?);
    browser.open(page());
    Some(browser)
}

/// The first chart over time with residuals: its plot, and the middle part of its chart in the window.
const OVER_TIME: &str = "window.hostSimCharts.find(one => one.kind === 'time')";

/// Brings the first chart over time into view; its left, top, width and height.
fn place_of_chart(browser: &mut Chromium) -> [f64; 4] {
    browser.until("window.hostSimCharts.length > 0");
    browser.value(&format!("{OVER_TIME}.plot.root.scrollIntoView({{ block: 'center' }})"));
    let place = browser.value(&format!(
        "(() => {{ const box = {OVER_TIME}.plot.over.getBoundingClientRect(); return [box.left, box.top, box.width, box.height]; }})()"
    ));
    [0, 1, 2, 3].map(|index| place[index].as_f64().unwrap())
}

fn scale(browser: &mut Chromium) -> (f64, f64) {
    let ends = browser.value(&format!("[{OVER_TIME}.plot.scales.x.min, {OVER_TIME}.plot.scales.x.max]"));
    (ends[0].as_f64().unwrap(), ends[1].as_f64().unwrap())
}

#[test]
fn the_page_draws_its_charts_without_a_complaint_and_asks_nothing_of_the_network() {
    let Some(mut browser) = opened() else { return };
    browser.until("window.hostSimCharts.length > 3");
    // Folded sections are drawn when they are opened.
    browser.value("document.querySelectorAll('details').forEach(folded => folded.open = true)");
    browser.until("document.querySelectorAll('figure.data:not(.live)').length === 0");
    let charts = browser.value("window.hostSimCharts.length").as_u64().unwrap();
    assert!(charts > 6 * 4, "{charts} charts of six recordings with four signals each");
    let drawn = "window.hostSimCharts.every(one => one.plot.ctx.canvas.width > 0 && one.plot.data[0].length > 1)";
    assert_eq!(browser.value(drawn), true);
    assert_eq!(browser.complaints(), Vec::<serde_json::Value>::new());
    assert_eq!(browser.requests(page()), Vec::<String>::new());
    let bytes = std::fs::metadata(page()).unwrap().len();
    assert!(bytes < 3_000_000, "{bytes} bytes");
}

#[test]
fn the_page_tells_where_what_how_sure_and_how_to_take_it_to_the_controller_in_this_order() {
    let Some(mut browser) = opened() else { return };
    let texts = |browser: &mut Chromium, selector: &str| -> Vec<String> {
        let found = browser.value(&format!("[...document.querySelectorAll('{selector}')].map(one => one.textContent)"));
        found.as_array().unwrap().iter().map(|text| text.as_str().unwrap().to_owned()).collect()
    };
    let headings = texts(&mut browser, "h2");
    let expected = [
        "Where",
        "What: internal-leakage",
        "How sure",
        "Where the error went",
        "Before and after",
        "Every recording",
        "Is the residual white?",
        "Base parameters",
        "Preprocessing",
        "To the controller",
    ];
    assert_eq!(headings, expected);
    // Each section with its purpose.
    let section = |browser: &mut Chromium, heading: &str, what: &str| -> Vec<String> {
        let found = browser.value(&format!(
            "[...[...document.querySelectorAll('section')].find(one => one.querySelector('h2')?.textContent === '{heading}')
                .querySelectorAll('{what}')].map(one => one.textContent)"
        ));
        found.as_array().unwrap().iter().map(|text| text.as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(section(&mut browser, "What: internal-leakage", "code"), ["Q_leak = G·(pa − pb)"]);
    let parameter = section(&mut browser, "What: internal-leakage", "td");
    assert_eq!(
        (parameter.len(), parameter[0].as_str(), parameter[3].as_str()),
        (5, "conductance_m3_per_s_pa", "m3/s/Pa")
    );
    assert!(parameter[4].contains(" l/min at 70 bar across the piston"), "{}", parameter[4]);
    let (value, deviation): (f64, f64) = (parameter[1].parse().unwrap(), parameter[2].parse().unwrap());
    assert!(value > 1.5e-12 && value < 2.5e-12 && deviation > 0.0 && deviation < 0.1 * value, "{value} ± {deviation}");
    let separated = section(&mut browser, "How sure", "th");
    assert_eq!(separated[..4], ["against", "test with the channels at hand", "distance", "with one more sensor"]);
    let each = section(&mut browser, "Before and after", "details td:first-child");
    assert_eq!(each.iter().filter(|name| name.contains(".csv")).count(), 6, "{each:?}");
    // Correlations of each signal with itself and with the input.
    let correlations = "[...document.querySelectorAll('figure.data script')].map(one => JSON.parse(one.textContent)) \
        .filter(one => one.y === 'correlation (shaded: 99 % band)' && one.band > 0 && one.layers.length === 2).map(one => one.title)";
    let correlations = browser.value(correlations);
    for signal in ["Position", "Pressure A", "Pressure B", "Spool"] {
        for with in ["with itself", "with the input"] {
            let titles = correlations.as_array().unwrap().iter().filter_map(|title| title.as_str());
            let there = titles.filter(|title| title.starts_with(&format!("{signal}: {with}"))).count();
            assert_eq!(there, 1, "{signal} {with}: {correlations}");
        }
    }
    let steps = section(&mut browser, "To the controller", "li");
    for (step, command) in steps.iter().zip(["--save-machine after.toml", "host-sim compare", "host-sim export"]) {
        assert!(step.contains(command), "{step}");
    }
    assert_eq!(steps.len(), 3);
}

#[test]
fn the_first_screen_has_the_verdict_the_improvement_and_a_picture() {
    let Some(mut browser) = opened() else { return };
    browser.resize(1280, 800, false);
    for part in ["h1", ".gains", "figure"] {
        let bottom = browser.value(&format!("document.querySelector('{part}').getBoundingClientRect().bottom"));
        assert!(bottom.as_f64().unwrap() < 800.0, "{part} ends at {bottom}");
    }
}

#[test]
fn dragging_zooms_all_panels_of_a_recording_and_a_double_click_shows_all_again() {
    let Some(mut browser) = opened() else { return };
    let [left, top, width, height] = place_of_chart(&mut browser);
    let whole = scale(&mut browser);
    let middle = top + 0.5 * height;
    browser.drag((left + 0.25 * width, middle), (left + 0.5 * width, middle));
    browser.until(&format!("{OVER_TIME}.plot.scales.x.max < {}", whole.1 - 0.4 * (whole.1 - whole.0)));
    let (from, to) = scale(&mut browser);
    let share = (to - from) / (whole.1 - whole.0);
    assert!((share - 0.25).abs() < 0.05, "{from} to {to} of {whole:?}");
    let together = format!(
        "window.hostSimCharts.filter(one => one.figure === {OVER_TIME}.figure).every(one => one.plot.scales.x.max === {to})"
    );
    browser.until(&together);
    browser.click((left + 0.5 * width, middle), 2);
    browser.until(&format!(
        "{OVER_TIME}.plot.scales.x.max === {} && {OVER_TIME}.plot.scales.x.min === {}",
        whole.1, whole.0
    ));
    assert_eq!(browser.complaints(), Vec::<serde_json::Value>::new());
}

#[test]
fn the_pointer_reads_values_with_their_units() {
    let Some(mut browser) = opened() else { return };
    let [left, top, width, height] = place_of_chart(&mut browser);
    browser.mouse("mouseMoved", (left + 0.4 * width, top + 0.5 * height), 0);
    let legend = format!("[...{OVER_TIME}.plot.root.querySelectorAll('.u-value')].map(cell => cell.textContent)");
    browser.until(&format!("{legend}[0].endsWith(' s') && {legend}[1].endsWith(' mm')"));
    let recorded = browser.value(&format!("{OVER_TIME}.plot.data[1][{OVER_TIME}.plot.cursor.idx]")).as_f64().unwrap();
    let shown = browser.value(&format!("{legend}[1]")).as_str().unwrap().to_owned();
    let read: f64 = shown.trim_end_matches(" mm").replace('−', "-").parse().unwrap();
    assert!((read - recorded).abs() < 0.01, "{shown} for {recorded}");
}

#[test]
fn a_click_on_the_legend_hides_a_trace_and_another_shows_it() {
    let Some(mut browser) = opened() else { return };
    place_of_chart(&mut browser);
    let shows = format!("{OVER_TIME}.plot.series[2].show");
    let label = browser.value(&format!(
        "(() => {{ const box = {OVER_TIME}.plot.root.querySelectorAll('.u-legend th')[2].getBoundingClientRect();
            return [box.left + 0.5 * box.width, box.top + 0.5 * box.height]; }})()"
    ));
    let at = (label[0].as_f64().unwrap(), label[1].as_f64().unwrap());
    assert_eq!(browser.value(&shows), true);
    browser.click(at, 1);
    browser.until(&format!("{shows} === false"));
    browser.click(at, 1);
    browser.until(&format!("{shows} === true"));
}

/// The rows of all recordings over time: the chart that shows the located intervals.
const ROWS: &str = "window.hostSimCharts.find(one => one.kind === 'rows')";

/// Position of a value of the chart of rows in the window.
fn on_rows(browser: &mut Chromium, time_s: f64, height: f64) -> (f64, f64) {
    let at = browser.value(&format!(
        "(() => {{ const plot = {ROWS}.plot, box = plot.over.getBoundingClientRect();
            return [box.left + plot.valToPos({time_s}, 'x'), box.top + plot.valToPos({height}, 'y')]; }})()"
    ));
    (at[0].as_f64().unwrap(), at[1].as_f64().unwrap())
}

#[test]
fn the_located_intervals_are_shaded_in_the_row_of_their_recording_and_zoomed() {
    let Some(mut browser) = opened() else { return };
    browser.until(&format!("{ROWS} !== undefined"));
    browser.value(&format!("{ROWS}.plot.root.scrollIntoView({{ block: 'center' }})"));
    let data = browser.value(&format!("JSON.parse({ROWS}.figure.querySelector('script').textContent)"));
    let rows = data["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4, "a row for each training recording");
    // Above the highest trace: in the middle of an interval, and outside any interval.
    let ink = |browser: &mut Chromium, row: usize, time_s: f64| {
        let height = (rows.len() - 1 - row) as f64 + 0.9;
        browser.value(&format!(
            "(() => {{ const plot = {ROWS}.plot; return [...plot.ctx.getImageData(Math.round(plot.valToPos({time_s}, 'x', true)),
                Math.round(plot.valToPos({height}, 'y', true)), 1, 1).data].join(); }})()"
        ))
    };
    let last = browser.value(&format!("{ROWS}.plot.scales.x.max")).as_f64().unwrap();
    let mut intervals = 0;
    for (index, row) in rows.iter().enumerate() {
        let shade: Vec<(f64, f64)> = row["shade"]
            .as_array()
            .unwrap()
            .iter()
            .map(|ends| (ends[0].as_f64().unwrap(), ends[1].as_f64().unwrap()))
            .collect();
        let free = (1..200).map(|step| last * f64::from(step) / 200.0);
        let free =
            free.into_iter().find(|time| shade.iter().all(|(from, to)| *time < from - 0.05 || *time > to + 0.05));
        let Some(free) = free else { continue };
        for (from, to) in &shade {
            intervals += 1;
            assert_ne!(
                ink(&mut browser, index, 0.5 * (from + to)),
                ink(&mut browser, index, free),
                "row {index}: {from} to {to} s"
            );
        }
    }
    assert!(intervals > 3, "{intervals} intervals");

    let (from, to) = (on_rows(&mut browser, 0.25 * last, 1.5), on_rows(&mut browser, 0.5 * last, 1.5));
    browser.drag(from, to);
    browser.until(&format!("Math.abs({ROWS}.plot.scales.x.max - {}) < {}", 0.5 * last, 0.02 * last));
    browser.click(from, 2);
    browser.until(&format!("{ROWS}.plot.scales.x.max === {last}"));
    // The pointer reads the row under it; a button hides the traces of its kind.
    let (x, y) = on_rows(&mut browser, 0.5 * last, 0.5);
    browser.mouse("mouseMoved", (x, y), 0);
    let name = rows[3]["label"].as_str().unwrap();
    browser.until(&format!("{ROWS}.figure.querySelector('.switches span').textContent.startsWith('{name} at ')"));
    browser.value(&format!("{ROWS}.figure.querySelector('.switches button').click()"));
    let shown = format!("{ROWS}.plot.series.slice(1).filter(one => one.show).length");
    assert_eq!(
        browser.value(&shown).as_u64().unwrap() + 4,
        browser.value(&format!("{ROWS}.plot.series.length - 1")).as_u64().unwrap()
    );
}

#[test]
fn the_map_over_two_states_tells_the_cell_under_the_pointer() {
    let Some(mut browser) = opened() else { return };
    let map = "[...document.querySelectorAll('figure.data')].find(one => JSON.parse(one.querySelector('script').textContent).kind === 'map')";
    browser.until(&format!("{map}.classList.contains('live')"));
    browser.value(&format!("{map}.scrollIntoView({{ block: 'center' }})"));
    let data = browser.value(&format!("JSON.parse({map}.querySelector('script').textContent)"));
    let number = |name: &str| data[name].as_f64().unwrap();
    let cells = data["cells"].as_array().unwrap();
    let full = cells.iter().position(|cell| !cell.is_null()).unwrap();
    let columns = usize::try_from(data["columns"].as_u64().unwrap()).unwrap();
    // The middle of that cell, as a share of the drawing.
    let across = (full % columns) as f64 + 0.5;
    let upwards = (full / columns) as f64 + 0.5;
    let x = number("left") + (number("right") - number("left")) * across / number("columns");
    let y = number("bottom") - (number("bottom") - number("top")) * upwards / number("rows");
    let at = browser.value(&format!(
        "(() => {{ const box = {map}.querySelector('svg').getBoundingClientRect();
            return [box.left + {} * box.width, box.top + {} * box.height]; }})()",
        x / number("width"),
        y / number("height")
    ));
    browser.mouse("mouseMoved", (at[0].as_f64().unwrap(), at[1].as_f64().unwrap()), 0);
    let rows = cells[full][1].as_u64().unwrap();
    browser.until(&format!("{map}.querySelector('.told').textContent.endsWith(', {rows} rows')"));
    let told = browser.value(&format!("{map}.querySelector('.told').textContent"));
    assert!(told.as_str().unwrap().starts_with(data["x"].as_str().unwrap()), "{told}");
}

#[test]
fn the_effects_own_picture_answers_the_pointer_and_hides_a_layer() {
    let Some(mut browser) = opened() else { return };
    let picture = "window.hostSimCharts.find(one => one.kind === 'figure')";
    browser.until(&format!("{picture} !== undefined"));
    browser.value(&format!("{picture}.plot.root.scrollIntoView({{ block: 'center' }})"));
    let place = browser.value(&format!(
        "(() => {{ const box = {picture}.plot.over.getBoundingClientRect(); return [box.left + 0.5 * box.width, box.top + 0.5 * box.height]; }})()"
    ));
    let at = (place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
    browser.mouse("mouseMoved", at, 0);
    let values = format!("[...{picture}.plot.root.querySelectorAll('.u-value')].map(cell => cell.textContent)");
    browser.until(&format!("{values}.slice(1).some(text => /^−?[0-9.]+ /.test(text))"));
    let legend = format!("{picture}.plot.root.querySelectorAll('.u-legend th')[1]");
    browser.value(&format!("{legend}.click()"));
    browser.until(&format!("{picture}.plot.series[1].show === false"));
    assert_eq!(browser.complaints(), Vec::<serde_json::Value>::new());
}

#[test]
fn a_phones_first_screen_has_the_verdict_and_the_improvement() {
    let Some(mut browser) = opened() else { return };
    browser.resize(390, 844, true);
    browser.open(page());
    for part in ["h1", ".gains"] {
        let bottom = browser.value(&format!("document.querySelector('{part}').getBoundingClientRect().bottom"));
        assert!(bottom.as_f64().unwrap() < 844.0, "{part} ends at {bottom}");
    }
    let top = browser.value("document.querySelector('figure').getBoundingClientRect().top");
    assert!(top.as_f64().unwrap() < 844.0, "the picture begins at {top}");
}

#[test]
fn nothing_is_wider_than_a_phone() {
    let Some(mut browser) = opened() else { return };
    browser.resize(390, 844, true);
    browser.open(page());
    browser.until("window.hostSimCharts.length > 3");
    browser.value("document.querySelectorAll('details').forEach(folded => folded.open = true)");
    browser.until("document.querySelectorAll('figure.data:not(.live)').length === 0");
    let width = browser.value("document.documentElement.scrollWidth");
    let widest = "[...document.querySelectorAll('body *')].filter(part => part.getBoundingClientRect().right > 391 && \
        !part.closest('table, pre, figure')).map(part => part.tagName + ' ' + part.className).slice(0, 5)";
    assert_eq!(width, 390, "{}", browser.value(widest));
    let charts = "window.hostSimCharts.every(one => one.plot.root.getBoundingClientRect().right <= 390)";
    assert_eq!(browser.value(charts), true);
}

#[test]
fn the_dark_has_a_dark_page_and_charts_that_are_read_on_it() {
    let Some(mut browser) = opened() else { return };
    let background = "getComputedStyle(document.body).backgroundColor";
    assert_eq!(browser.value(background), "rgb(255, 255, 255)");
    // The switch itself: the drawing changes with it.
    let light = browser.value(&format!("{OVER_TIME}.plot.series[2].stroke()"));
    browser.prefer("dark");
    browser.until(&format!("{background} !== 'rgb(255, 255, 255)'"));
    browser.until(&format!("{OVER_TIME}.plot.series[2].stroke() !== {light}"));
    assert_eq!(browser.complaints(), Vec::<serde_json::Value>::new());
}

#[test]
fn without_scripts_and_on_paper_the_drawings_are_there() {
    let Some(mut browser) = opened() else { return };
    browser.until("window.hostSimCharts.length > 3");
    // Evaluated from outside the page, because its own scripts are off.
    let shown = "[...document.querySelectorAll('figure svg')].filter(one => one.getClientRects().length > 0).length";
    let hidden = browser.value("document.querySelectorAll('figure.live:not(.drawn) > svg').length").as_u64().unwrap();
    let with_scripts = browser.value(shown).as_u64().unwrap();
    browser.call("Emulation.setEmulatedMedia", &serde_json::json!({ "media": "print" }));
    let on_paper = browser.value(shown).as_u64().unwrap();
    assert!(on_paper >= with_scripts + hidden && hidden > 3, "{on_paper} {with_scripts} {hidden}");
    browser.call("Emulation.setEmulatedMedia", &serde_json::json!({ "media": "" }));
    browser.allow_scripts(false);
    browser.open(page());
    assert_eq!(browser.value("typeof window.hostSimCharts"), "undefined");
    let without = browser.value(shown).as_u64().unwrap();
    assert!(without >= with_scripts + hidden, "{without} {with_scripts} {hidden}");
}
