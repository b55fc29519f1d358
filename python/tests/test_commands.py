"""Every command gives what the program of the same name writes."""

from __future__ import annotations

import csv
import json
import math
import re
import subprocess
from pathlib import Path

import host_sim
import pytest
from conftest import CASE, HOLDOUT, TRAIN

MACHINE = CASE / "machine.toml"


def document(path: Path) -> dict:
    return json.loads(path.read_text())


def without_its_making(page: str) -> str:
    """A page without what only the program knows: when it was made, and by which command."""
    short, count = re.subn(r'<details class="about">.*?</details>', "", page, flags=re.DOTALL)
    assert count == 1, page[:2000]
    return short


def test_inspect_gives_the_program_s_json(run, tmp_path):
    run("inspect", *TRAIN[:2], "--machine", MACHINE, "--json", "i.json")
    found = host_sim.inspect(TRAIN[:2], MACHINE)
    assert found.to_dict() == document(tmp_path / "i.json")
    assert [one["recording"] for one in found.recordings] == [path.name for path in TRAIN[:2]]


def test_compare_gives_the_program_s_json(run, tmp_path):
    run("compare", "--machine", MACHINE, "--recording", *TRAIN[:2], "--json", "c.json")
    found = host_sim.compare(MACHINE, TRAIN[:2])
    assert found.to_dict() == document(tmp_path / "c.json")
    signals = {fit.signal for fit in found.fits if fit.section == "end to end"}
    assert {"position", "pressure_a", "pressure_b"} <= signals
    assert len(found.drawings) == 2 and "<svg" in found.drawings[0]


def test_a_page_is_the_program_s_and_is_saved_and_shown_in_a_notebook(run, tmp_path):
    run("inspect", TRAIN[0], "--machine", MACHINE, "--report", "i.html")
    run("compare", TRAIN[0], "--machine", MACHINE, "--report", "c.html")
    run("fit", TRAIN[0], "--machine", MACHINE, "--holdout", HOLDOUT[0], "--report", "f.html")
    results = {
        "i.html": host_sim.inspect(TRAIN[0], MACHINE),
        "c.html": host_sim.compare(MACHINE, TRAIN[0]),
        "f.html": host_sim.fit(MACHINE, TRAIN[0], holdout=HOLDOUT[0]),
    }
    for name, found in results.items():
        found.save_report(tmp_path / "saved.html")
        saved, written = (tmp_path / "saved.html", tmp_path / name)
        assert without_its_making(saved.read_text(encoding="utf-8")) == without_its_making(written.read_text(encoding="utf-8"))
        assert found._repr_html_().startswith("<iframe srcdoc=")


def test_a_page_says_when_by_which_call_and_of_what_it_was_made_as_the_program_s_does(run, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1767225600")
    run("inspect", TRAIN[0], "--machine", MACHINE, "--report", "i.html")
    run("compare", TRAIN[0], "--machine", MACHINE, "--report", "c.html")
    run("fit", TRAIN[0], "--machine", MACHINE, "--holdout", HOLDOUT[0], "--report", "f.html")
    results = {
        ("i.html", "inspect"): host_sim.inspect(TRAIN[0], MACHINE),
        ("c.html", "compare"): host_sim.compare(MACHINE, TRAIN[0]),
        ("f.html", "fit"): host_sim.fit(MACHINE, [TRAIN[0]], holdout=HOLDOUT[0]),
    }
    for (name, function), found in results.items():
        page, program = found.to_html(), (tmp_path / name).read_text(encoding="utf-8")
        assert "2026-01-01 00:00 +00:00" in page and str(MACHINE) in page
        command = re.compile(r"<dt>Command</dt><dd><code>(.*?)</code></dd>")
        assert command.sub("", page) == command.sub("", program)
        (call,) = command.findall(page)
        assert call.startswith(f"host_sim.{function}(") and str(TRAIN[0]) in call
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    page = host_sim.inspect({"time [s]": [0.0, 0.1, 0.2], "position [mm]": [1.0, 2.0, 3.0]}, threads=1).to_html()
    assert "host_sim.inspect(&lt;dict&gt;, threads=1)" in page
    assert re.search(r"<summary>20\d\d-\d\d-\d\d \d\d:\d\d [+-]\d\d:\d\d · host-sim", page)


def test_what_is_certainly_wrong_with_a_recording_is_noted_and_stands_on_the_pages():
    frame = host_sim.read(TRAIN[0]).to_pandas()
    frame["position [m]"] *= -1
    compared = host_sim.compare(MACHINE, frame)
    wrong = "position seems to run the other way"
    assert any(wrong in note and "mend this first" in note for note in compared.notes), compared.notes
    assert f"Doubt: {wrong}" in compared.to_html()
    with pytest.raises(host_sim.Error, match="or give as_recorded=True"):
        host_sim.fit(MACHINE, frame)
    assert f"Doubt: {wrong}" in host_sim.fit(MACHINE, frame, as_recorded=True).to_html()


def test_fit_gives_the_program_s_json_and_machine_file(run, tmp_path):
    run("fit", "--machine", MACHINE, "--train", *TRAIN, "--save-machine", "f.toml", "--json", "f.json")
    found = host_sim.fit(MACHINE, TRAIN)
    assert found.to_dict() == document(tmp_path / "f.json")
    assert found.machine.to_toml() == (tmp_path / "f.toml").read_text()
    assert found.converged and found.parameters
    assert found.machine.to_dict() != host_sim.Machine(MACHINE).to_dict()


def rows_of(path: Path) -> dict[str, list[float]]:
    with path.open(newline="") as text:
        rows = list(csv.reader(text))
    return {header: [float(row[index]) for row in rows[1:]] for index, header in enumerate(rows[0])}


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_simulate_gives_the_numbers_of_the_program_s_file(run, tmp_path, arithmetic):
    run("simulate", "--machine", MACHINE, "--recording", TRAIN[0], "--out", "s.csv", "--arithmetic", arithmetic)
    found = host_sim.simulate(MACHINE, TRAIN[0], arithmetic=arithmetic)
    assert found.to_dict() == rows_of(tmp_path / "s.csv")
    assert list(found["position [m]"]) == found.to_dict()["position [m]"]
    assert "<svg" in found._repr_html_()


def test_simulate_answers_an_input_signal_as_the_program_does(run, tmp_path):
    run("simulate", "--machine", MACHINE, "--input", "step:4V,0.5s", "--out", "s.csv")
    assert host_sim.simulate(MACHINE, input="step:4V,0.5s").to_dict() == rows_of(tmp_path / "s.csv")


def test_plan_gives_the_program_s_json_and_excitation(run, tmp_path):
    sensors = ["position:0.05mm"]
    written = ["--json", "p.json", "--out", "e.csv"]
    run("plan", "--machine", MACHINE, "--sensors", ",".join(sensors), "--seconds", "5", *written)
    found = host_sim.plan(MACHINE, sensors, longest_s=5.0)
    assert found.to_dict() == document(tmp_path / "p.json")
    assert found.excitation.table().to_dict() == rows_of(tmp_path / "e.csv")
    assert found.tests and found.claimed
    assert "<svg" in found._repr_html_()


@pytest.fixture(scope="module")
def diagnosed() -> host_sim.Diagnosis:
    return host_sim.diagnose(CASE)


@pytest.fixture(scope="module")
def written(program, tmp_path_factory) -> Path:
    """What the program writes for the shipped case."""
    folder = tmp_path_factory.mktemp("diagnosis")
    files = ["--json", "d.json", "--save-machine", "f.toml", "--report", "d.html"]
    subprocess.run([program, "diagnose", str(CASE), *files], cwd=folder, capture_output=True, check=True)
    return folder


def test_diagnose_gives_the_program_s_json_machine_file_and_page(diagnosed, written):
    assert diagnosed.to_dict() == document(written / "d.json")
    assert diagnosed.machine.to_toml() == (written / "f.toml").read_text()
    assert without_its_making(diagnosed.to_html()) == without_its_making((written / "d.html").read_text())
    assert f"host_sim.diagnose(&#39;{CASE}&#39;)" in diagnosed.to_html() or f"host_sim.diagnose('{CASE}')" in diagnosed.to_html()


def test_a_diagnosis_is_typed(diagnosed):
    assert diagnosed.verdict == "missing-physics" and diagnosed.confirmed and diagnosed.is_finished
    (finding,) = diagnosed.findings
    assert (finding.effect, finding.subsystem) == ("internal-leakage", "chambers")
    (leakage,) = finding.parameters
    assert math.isclose(leakage.value, 2e-12, rel_tol=0.02) and leakage.unit == "m3/s/Pa"
    assert diagnosed.fit["holdout"]["after"]["position"] > diagnosed.fit["holdout"]["before"]["position"]
    assert diagnosed.machine.effects == ["internal-leakage"]
    assert diagnosed.machine["effects.internal-leakage.conductance_m3_per_s_pa"] == pytest.approx(leakage.value, rel=1e-5)


def test_what_has_changed_since_is_asked_as_by_the_program(diagnosed, run, tmp_path):
    diagnosed.machine.save(tmp_path / "then.toml")
    run("diagnose", "--since", "then.toml", "--train", *TRAIN, "--holdout", *HOLDOUT, "--json", "d.json")
    found = host_sim.diagnose(tmp_path / "then.toml", TRAIN, HOLDOUT, since=True)
    assert found.to_dict() == document(tmp_path / "d.json")
    assert found.verdict == "nothing-missing" and found.findings == []


def test_a_diagnosis_shows_its_trajectories(diagnosed):
    frame = diagnosed.trajectories("holdout-1.csv").to_pandas()
    recorded = host_sim.read(HOLDOUT[0])["position"]
    assert (frame["position recorded [m]"].to_numpy() == recorded).all()
    off = {which: (frame[f"position {which} [m]"] - frame["position recorded [m]"]).std() for which in ("before", "after")}
    assert off["after"] < 0.5 * off["before"]
    with pytest.raises(KeyError, match="holdout-1.csv"):
        diagnosed.trajectories("another.csv")


def test_a_diagnosis_is_its_page_in_a_notebook(diagnosed):
    shown = diagnosed._repr_html_()
    assert shown.startswith("<iframe srcdoc=") and "&lt;svg" in shown


def test_the_number_of_threads_changes_no_digit(diagnosed):
    two = host_sim.fit(MACHINE, TRAIN[:2], threads=2)
    assert host_sim.fit(MACHINE, TRAIN[:2], threads=1).to_dict() == two.to_dict()
    with pytest.raises(host_sim.Error, match="at least 1"):
        host_sim.inspect(TRAIN[0], threads=0)
