//! The computer on which everything is measured.

use std::process::Command;

/// The first line that a program prints, or a note that the program is missing.
fn first_line(program: &str, arguments: &[&str]) -> String {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let output = Command::new(program).args(arguments).current_dir(root).output();
    let line = output.ok().filter(|output| output.status.success()).and_then(|output| {
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        text.lines().next().map(str::to_owned)
    });
    line.unwrap_or_else(|| format!("no {program}"))
}

fn processor() -> std::io::Result<String> {
    let info = std::fs::read_to_string("/proc/cpuinfo")?;
    let of = |key: &str| {
        let line = info.lines().find(|line| line.starts_with(key));
        line.and_then(|line| line.split_once(": ")).map_or("?", |(_, value)| value).to_owned()
    };
    Ok(format!("{} (family {}, model {})", of("model name"), of("cpu family"), of("model\t")))
}

/// How many programs wanted to compute, as a mean of the last minute.
pub(crate) fn load() -> std::io::Result<String> {
    let load = std::fs::read_to_string("/proc/loadavg")?;
    Ok(load.split_whitespace().next().unwrap_or("?").to_owned())
}

/// Machine, versions and date, as a list.
pub(crate) fn described() -> std::io::Result<String> {
    let cores = std::thread::available_parallelism()?;
    let load = load()?;
    let commit = first_line("git", &["describe", "--always", "--dirty", "--exclude=*"]);
    Ok(format!(
        "- {}, commit {commit}\n- {}, {cores} cores; load at the start {load}\n- {}, release profile, {}\n\
         - {}; {}\n- {}\n",
        first_line("date", &["-u", "+%Y-%m-%d"]),
        processor()?,
        first_line("rustc", &["--version"]),
        if cfg!(target_feature = "avx2") { "AVX2" } else { "any processor" },
        first_line("gcc", &["--version"]),
        first_line("arm-none-eabi-gcc", &["--version"]),
        first_line("qemu-system-arm", &["--version"]),
    ))
}

/// Peak memory of this process, kB; `None` where the system does not report it.
pub(crate) fn peak_kb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Computing time of all threads of this process, s; NaN where the system does not report it.
#[cfg(unix)]
pub(crate) fn computed_s() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Computing time of all threads of this process, s; NaN where the system does not report it.
#[cfg(not(unix))]
pub(crate) fn computed_s() -> f64 {
    f64::NAN
}
