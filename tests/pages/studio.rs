//! The studio in a real browser: files are dropped, a diagnosis is run and stopped, results are saved, and they are the program's to the byte.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use clap::Parser;
use host_sim::cli::{self, Cli, Console};
use serde_json::json;
use system_tests::at_hand::shared;
use system_tests::emulator::{builds_for, built_in};
use system_tests::page::without_its_making;
use tempfile::TempDir;

use super::chromium::{Chromium, program};

/// Largest page.
const MOST_BYTES: u64 = 12_000_000;
/// Longest time of the studio over that of the program on one thread.
const MOST_TIMES: f64 = 4.0;
/// Concealed cases whose documents are compared.
const CONCEALED: [&str; 5] = ["d00", "d01", "d02", "d03", "d04"];
/// Longest that a diagnosis takes in the browser.
const PATIENCE: Duration = Duration::from_mins(5);

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/press-63-40").canonicalize().unwrap()
}

/// The page, built once; without the target for it, none.
fn studio() -> Option<&'static Path> {
    static PAGE: OnceLock<Option<PathBuf>> = OnceLock::new();
    let built = PAGE.get_or_init(|| {
        builds_for(studio_page::TARGET).then(|| {
            let folder = built_in("studio");
            let page = folder.join("studio.html");
            let html = studio_page::html(&folder).unwrap();
            std::fs::write(&page, html).unwrap();
            page
        })
    });
    built.as_deref()
}

/// The studio, open and ready; what it saves goes to a folder of its own. One at a time: times are compared, and a studio takes a core.
struct Opened {
    browser: Chromium,
    saved: TempDir,
    _alone: MutexGuard<'static, ()>,
}

fn opened() -> Option<Opened> {
    static ALONE: Mutex<()> = Mutex::new(());
    let program = program()?;
    // A test that failed has left nothing that another one uses.
    let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let page = studio()?;
    let mut browser = Chromium::start(&program);
    let saved = tempfile::tempdir().unwrap();
    let to = json!({ "behavior": "allow", "downloadPath": saved.path() });
    browser.call("Page.setDownloadBehavior", &to);
    browser.open(page);
    browser.until("document.getElementById('state').textContent === 'Ready.'");
    Some(Opened { browser, saved, _alone: alone })
}

impl Opened {
    /// Drops files on the page, as a user's file manager does, and waits until so many recordings are listed.
    fn drop_files(&mut self, files: &[PathBuf], recordings: usize) {
        let data = json!({ "items": [], "files": files, "dragOperationsMask": 1 });
        for what in ["dragEnter", "dragOver", "drop"] {
            self.browser.call("Input.dispatchDragEvent", &json!({ "type": what, "x": 300, "y": 250, "data": data }));
        }
        self.browser.until(&format!("document.querySelectorAll('#list tbody tr').length === {recordings}"));
    }

    /// Drops all that a diagnosis needs of a folder.
    fn drop_case(&mut self, folder: &Path) {
        let files = case(folder);
        self.drop_files(&files, files.len() - 1);
        self.browser.until("!document.querySelector('[data-command=diagnose]').disabled");
    }

    fn click_on(&mut self, selector: &str) {
        self.browser.value(&format!("document.querySelector('{selector}').click()"));
    }

    fn text_of(&mut self, selector: &str) -> String {
        let text = self.browser.value(&format!("document.querySelector('{selector}').textContent"));
        text.as_str().unwrap().to_owned()
    }

    /// Runs a command to its end; what the page says of it then.
    fn run(&mut self, command: &str) -> String {
        self.click_on(&format!("[data-command={command}]"));
        let begun = Instant::now();
        loop {
            let said = self.text_of("#state");
            if said.contains("done") || said.contains("stopped") {
                return said;
            }
            assert!(begun.elapsed() < PATIENCE, "{command} does not end: {said}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Clicks a button that saves a file; the file's text.
    fn save(&mut self, label: &str, name: &str) -> String {
        self.browser.value(&format!(
            "[...document.querySelectorAll('#result button')].find(one => one.textContent === '{label}').click()"
        ));
        let file = self.saved.path().join(name);
        let begun = Instant::now();
        while !file.exists() {
            assert!(begun.elapsed() < PATIENCE, "{name} was never saved");
            std::thread::sleep(Duration::from_millis(20));
        }
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        text
    }
}

/// The machine file and the recordings of a folder.
fn case(folder: &Path) -> Vec<PathBuf> {
    let named = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_str().unwrap();
        name == "machine.toml" || name.starts_with("train-") || name.starts_with("holdout-")
    };
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(named).map(|path| path.canonicalize().unwrap()).collect()
}

/// What the program writes for a folder on one thread: document, machine file, page; and how long it takes, s.
fn by_the_program(folder: &Path) -> ([String; 3], f64) {
    let written = tempfile::tempdir().unwrap();
    let [json, machine, page] = ["d.json", "d.toml", "d.html"].map(|name| written.path().join(name));
    let arguments = [
        "host-sim".as_ref(),
        "diagnose".as_ref(),
        folder.as_os_str(),
        "--json".as_ref(),
        json.as_os_str(),
        "--save-machine".as_ref(),
        machine.as_os_str(),
        "--report".as_ref(),
        page.as_os_str(),
    ];
    let command = Cli::try_parse_from(arguments).unwrap().command;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let begun = Instant::now();
    let run = || cli::run(&command, &mut Console::into_buffer(&mut Vec::new())).map_err(Box::new);
    pool.install(run).unwrap();
    let took_s = begun.elapsed().as_secs_f64();
    ([json, machine, page].map(|file| std::fs::read_to_string(file).unwrap()), took_s)
}

/// The seconds in `diagnose: done in 5.2 s`.
fn seconds(said: &str) -> f64 {
    let number = said.strip_prefix("diagnose: done in ").and_then(|rest| rest.strip_suffix(" s"));
    number.unwrap_or_else(|| panic!("{said}")).parse().unwrap()
}

#[test]
fn the_studio_gives_what_the_program_gives_to_the_byte_in_at_most_four_times_its_time() {
    let Some(mut opened) = opened() else { return };
    let concealed = shared("concealed").map(|folder| CONCEALED.map(|name| folder.join(name))).into_iter().flatten();
    let (mut by_studio, mut by_program) = (0.0, 0.0);
    for folder in std::iter::once(example()).chain(concealed) {
        let ([json, machine, page], took_s) = by_the_program(&folder);
        opened.browser.open(studio().unwrap());
        opened.browser.until("document.getElementById('state').textContent === 'Ready.'");
        opened.drop_case(&folder);
        by_studio += seconds(&opened.run("diagnose"));
        by_program += took_s;
        let of = folder.display();
        assert!(opened.save("Save JSON", "diagnose.json") == json, "{of}: another document");
        assert!(opened.save("Save the machine file", "diagnose.toml") == machine, "{of}: another machine file");
        let saved = opened.save("Save the page", "diagnose.html");
        assert!(without_its_making(&saved) == without_its_making(&page), "{of}: another page");
    }
    let times = by_studio / by_program;
    println!("studio {by_studio:.1} s, program on one thread {by_program:.1} s: {times:.2} times");
    assert!(times < MOST_TIMES, "the studio takes {times:.2} times as long as the program on one thread");
}

#[test]
fn the_page_is_small_and_asks_nothing_of_the_network() {
    let Some(mut opened) = opened() else { return };
    let bytes = std::fs::metadata(studio().unwrap()).unwrap().len();
    println!("{bytes} bytes");
    assert!(bytes < MOST_BYTES, "{bytes} bytes");
    opened.drop_case(&example());
    assert!(opened.run("inspect").starts_with("inspect: done"));
    assert!(opened.text_of("#promise").contains("Nothing leaves this computer"));
    let requests = opened.browser.requests(studio().unwrap());
    let left: Vec<String> = requests.into_iter().filter(|address| !address.starts_with("blob:")).collect();
    assert_eq!(left, Vec::<String>::new());
    assert_eq!(opened.browser.complaints(), Vec::<serde_json::Value>::new());
    // Nor could it: the browser refuses.
    let refused = "fetch('http://127.0.0.1:9/').then(() => 'sent', error => error.name)";
    assert_eq!(opened.browser.value(refused), "TypeError");
    let complaint = opened.browser.complaints().iter().map(ToString::to_string).collect::<String>();
    assert!(complaint.contains("Content Security Policy"), "{complaint}");
}

#[test]
fn a_diagnosis_that_is_stopped_ends_at_once_and_leaves_the_page_as_it_was() {
    let Some(mut opened) = opened() else { return };
    opened.drop_case(&example());
    opened.click_on("[data-command=diagnose]");
    opened.browser.until("document.getElementById('bar').value > 0");
    opened.click_on("#stop");
    opened.browser.until("document.getElementById('state').textContent.startsWith('diagnose: stopped after ')");
    assert_eq!(opened.browser.value("document.getElementById('results').hidden"), true);
    let said = opened.run("inspect");
    assert!(said.starts_with("inspect: done"), "{said}");
    assert!(opened.text_of("#result pre").contains("position"), "the files are still there");
}

#[test]
fn a_file_that_cannot_be_read_is_refused_with_place_and_reason_and_the_others_go_on() {
    let Some(mut opened) = opened() else { return };
    let folder = tempfile::tempdir().unwrap();
    let written = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let files = [
        written("text.csv", b"time [s],position [mm]\n0,1\n0.1,abc\n0.2,3\n"),
        written("cut.csv.gz", b"\x1f\x8b\x08\x00\x00\x00"),
        written("good.csv", b"time [s],position [mm]\n0,1\n0.1,2\n0.2,3\n"),
    ];
    opened.drop_files(&files, 3);
    let problems = opened.browser.value("[...document.querySelectorAll('#list .problem')].map(one => one.textContent)");
    let problems: Vec<&str> = problems.as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect();
    assert_eq!(problems.len(), 2, "{problems:?}");
    assert!(problems.iter().any(|text| text.contains("abc") && text.contains("text.csv:3")), "{problems:?}");
    assert!(problems.iter().any(|text| text.contains("cut.csv.gz")), "{problems:?}");
    let said = opened.run("inspect");
    assert_eq!(said, "inspect: not done");
    assert!(opened.text_of("#refused").contains("text.csv") || opened.text_of("#refused").contains("cut.csv.gz"));
    for _ in 0..2 {
        opened.browser.value("[...document.querySelectorAll('#list tr')].find(one => one.querySelector('.problem')).querySelector('button').click()");
        std::thread::sleep(Duration::from_millis(100));
    }
    assert!(opened.run("inspect").starts_with("inspect: done"));
}

#[test]
fn a_drive_from_its_data_sheet_and_columns_mapped_by_hand_make_a_comparison() {
    let Some(mut opened) = opened() else { return };
    let folder = tempfile::tempdir().unwrap();
    let foreign = std::fs::read_to_string(example().join("train-1.csv")).unwrap().replacen("position", "Kolbenweg", 1);
    let run = folder.path().join("run.csv");
    std::fs::write(&run, foreign).unwrap();
    opened.drop_files(&[run], 1);
    assert_eq!(opened.browser.value("document.querySelector('[data-command=compare]').disabled"), true);
    let answers = json!({ "bore": "63mm", "rod": "40mm", "stroke": "300mm", "mass": "18.3kg", "supply": "70bar", "rated-flow": "5l/min",
        "rated-drop": "5bar", "rated-signal": "10V" });
    let fill = |browser: &mut Chromium, answers: &serde_json::Value| {
        browser.value(&format!(
            "Object.entries({answers}).forEach(([flag, text]) => document.querySelector(`#form [name=${{flag}}]`).value = text)"
        ));
    };
    fill(&mut opened.browser, &answers);
    opened.click_on("#form button");
    opened.browser.until("document.querySelector('#form .problem').textContent !== ''");
    let missing = opened.text_of("#form .problem");
    assert!(missing.contains("valve-response"), "{missing}");
    fill(&mut opened.browser, &json!({ "valve-response": "96ms" }));
    opened.click_on("#form button");
    opened.browser.until("document.getElementById('machine').value.includes('[valve]')");
    opened.browser.value("document.getElementById('mapping').open = true");
    opened.browser.until("document.querySelector('#columns select') !== null");
    opened.browser.value(
        "[...document.querySelectorAll('#columns select')].find(one => one.dataset.header.startsWith('Kolbenweg')).value = 'position'",
    );
    opened.click_on("#write-map");
    opened.browser.until("document.getElementById('machine').value.includes('position = \"Kolbenweg')");
    let said = opened.run("compare");
    assert!(said.starts_with("compare: done"), "{said}: {}", opened.text_of("#refused"));
    let document: serde_json::Value = serde_json::from_str(&opened.save("Save JSON", "compare.json")).unwrap();
    assert_eq!(document["schema"], "host-sim/comparison/1");
    opened.browser.until("document.querySelector('#result iframe')?.srcdoc.includes('Comparison of')");
}

#[test]
fn a_column_can_be_unmapped_and_a_result_that_is_older_than_its_inputs_says_so() {
    let Some(mut opened) = opened() else { return };
    opened.drop_case(&example());
    let is_older = |opened: &mut Opened| opened.browser.value("!document.getElementById('older').hidden") == true;
    let signals = |opened: &mut Opened| {
        let document: serde_json::Value = serde_json::from_str(&opened.save("Save JSON", "inspect.json")).unwrap();
        document["recordings"][0]["channels"].to_string()
    };
    assert!(opened.run("inspect").starts_with("inspect: done"));
    assert!(!is_older(&mut opened) && signals(&mut opened).contains("\"pressure_a\""));
    opened.browser.value("document.getElementById('mapping').open = true");
    let choice =
        "[...document.querySelectorAll('#columns select')].find(one => one.dataset.header.startsWith('pressure_a'))";
    opened.browser.until(&format!("{choice}?.value === 'pressure_a'"));
    opened.browser.value(&format!("{choice}.value = ''"));
    opened.click_on("#write-map");
    opened.browser.until("document.getElementById('machine').value.includes('unused = [\"pressure_a')");
    opened.browser.until(&format!("{choice}?.value === ''"));
    assert!(is_older(&mut opened), "the mapping has changed");
    assert_eq!(opened.text_of("#tabs button"), "inspect (older)");
    assert!(opened.run("inspect").starts_with("inspect: done"));
    assert!(!is_older(&mut opened) && !signals(&mut opened).contains("\"pressure_a\""));
    opened.browser.value("{ const limit = document.getElementById('limit'); limit.value = '10'; limit.dispatchEvent(new Event('input')); }");
    assert!(!is_older(&mut opened), "no inspection depends on it");
    opened.click_on("#list button");
    assert!(is_older(&mut opened), "a recording is gone");
    assert!(opened.run("compare").starts_with("compare: done"));
    assert!(!is_older(&mut opened));
    opened.browser.value("{ const text = document.getElementById('machine'); text.value += '\\n# seen'; text.dispatchEvent(new Event('change')); }");
    opened.browser.until("!document.getElementById('older').hidden");
}

#[test]
fn on_a_phone_nothing_is_wider_than_the_screen() {
    let Some(mut opened) = opened() else { return };
    opened.browser.resize(375, 812, true);
    opened.drop_case(&example());
    for scheme in ["light", "dark"] {
        opened.browser.prefer(scheme);
        opened.browser.value("document.querySelectorAll('details').forEach(one => one.open = true)");
        opened.browser.until("document.querySelector('#columns select') !== null");
        assert!(opened.run("inspect").starts_with("inspect: done"));
        let width = opened.browser.value("document.documentElement.scrollWidth").as_u64().unwrap();
        assert!(width <= 375, "{scheme}: {width}");
    }
}
