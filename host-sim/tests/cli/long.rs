//! The memory that a long recording takes.

use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{done, program, root};

/// Peak memory of a process so far, MiB; `None` once it has ended.
fn peak_mib(process: u32) -> Option<f64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().trim_end_matches(" kB").parse().ok()?;
    Some(kib / 1024.0)
}

#[test]
#[ignore = "three minutes: cargo test -p host-sim --features virtual-plant --test cli an_hour -- --ignored --nocapture"]
fn an_hour_of_training_takes_less_than_two_minutes_and_two_gibibytes() {
    let folder = tempfile::tempdir().unwrap();
    let preset = root().join("presets/press-63-40.toml").display().to_string();
    let testbed = ["testbed", "--machine", &preset, "--effect", "internal-leakage=2e-12", "--closed-loop", "80"];
    let recordings = ["--train", "random:4V,0.3s,2s,3600s,seed=1", "--holdout", "random:4V,0.3s,2s,10s,seed=99"];
    done(folder.path(), &[&testbed[..], &recordings, &["--seed", "7", "--out", "case"]].concat());

    let start = Instant::now();
    let mut command = program(folder.path(), &["diagnose", "case", "--report", "report.html", "--json", "found.json"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let mut peak = 0.0;
    while let Some(now) = peak_mib(child.id()) {
        peak = now;
        sleep(Duration::from_millis(20));
    }
    assert!(child.wait().unwrap().success());
    let took_s = start.elapsed().as_secs_f64();
    println!("an hour: {took_s:.0} s, {peak:.0} MiB");
    assert!(took_s < 120.0 && peak < 2048.0, "{took_s} s, {peak} MiB");
    assert!(fs::read_to_string(folder.path().join("found.json")).unwrap().contains("internal-leakage"));
}
