//! The page: its contents, and a check that names stay names.

use std::fs;

use super::{done, example};

#[test]
fn the_page_holds_its_sections_and_escapes_every_name() {
    let out = tempfile::tempdir().unwrap();
    let machine = fs::read_to_string(example("machine.toml")).unwrap();
    let named: String = machine
        .lines()
        .map(|line| if line.starts_with("name") { "name = \"<script>alert(1)</script>\"" } else { line })
        .flat_map(|line| [line, "\n"])
        .collect();
    fs::write(out.path().join("m.toml"), named).unwrap();
    for (input, name) in [("steps:6V", "a&b <i>.csv"), ("random:8V,0.1s,0.5s,3s,seed=2", "held.csv")] {
        done(out.path(), &["simulate", "--machine", "m.toml", "--input", input, "--out", name]);
    }
    let diagnose = ["diagnose", "--machine", "m.toml", "--train", "a&b <i>.csv", "--holdout", "held.csv"];
    let printed = done(out.path(), &[&diagnose[..], &["--report", "r.html", "--json", "r.json"]].concat());
    assert!(
        printed.contains("square error over noise², held out") && printed.contains("prepared   noise: "),
        "{printed}"
    );
    let page = fs::read_to_string(out.path().join("r.html")).unwrap();
    for section in [
        "Base parameters",
        "How sure",
        "Where the error went",
        "Before and after",
        "Every recording",
        "Is the residual white?",
        "Preprocessing",
        "To the controller",
    ] {
        assert!(page.contains(&format!(">{section}</h2>")) && page.contains(&format!(">{section}</a>")), "{section}");
    }
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;") && page.contains("a&amp;b &lt;i&gt;.csv"));
    assert!(!page.contains("<script>alert") && !page.contains("<i>"), "a name became markup");
    assert!(
        !page.contains("http://")
            || page.matches("http://").count() == page.matches("http://www.w3.org/2000/svg").count()
    );
    // The chart library contains its own address; the page forbids any access to it.
    let page = page.replace("https://github.com/leeoniya/uPlot", "");
    assert!(page.contains("default-src 'none'"));
    assert!(!page.contains("https://") && !page.contains("<link") && !page.contains("<img"), "nothing is fetched");
    assert!(page.len() < 3_000_000, "{}", page.len());
    let json = fs::read_to_string(out.path().join("r.json")).unwrap();
    for key in ["\"waterfall\"", "\"residuals\"", "\"prepared\"", "\"square_over_noise\"", "\"outside_band\""] {
        assert!(json.contains(key), "{key}");
    }
}
