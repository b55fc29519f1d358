"""An error says what the program says, and where."""

from __future__ import annotations

from pathlib import Path

import host_sim
import numpy
import polars
import pytest
from conftest import CASE, TRAIN

MACHINE = CASE / "machine.toml"


def refused(call) -> host_sim.Error:
    with pytest.raises(host_sim.Error) as raised:
        call()
    return raised.value


def test_a_bad_cell_has_file_row_and_column_and_the_program_s_text(run, tmp_path: Path):
    path = tmp_path / "run.csv"
    path.write_text("time [s],command [V],position [mm]\n0,1,125\n0.1,1,abc\n0.2,1,126\n")
    error = refused(lambda: host_sim.read(path))
    assert (error.file, error.row, error.key) == (str(path), 3, "position [mm]")
    assert f"error: {error}\n" == run("inspect", path, fails=True)


def test_a_bad_machine_file_has_file_line_and_key_and_the_program_s_text(run, tmp_path: Path):
    path = tmp_path / "machine.toml"
    text = MACHINE.read_text()
    path.write_text(text.replace("moving_mass_kg = ", "moving_mass_kg = -"))
    error = refused(lambda: host_sim.Machine(path))
    line = next(number for number, line in enumerate(text.splitlines(), 1) if line.startswith("moving_mass_kg"))
    assert (error.file, error.row, error.key) == (str(path), line, "cylinder.moving_mass_kg")
    assert f"error: {error}\n" == run("inspect", TRAIN[0], "--machine", path, fails=True)


def test_a_bad_value_in_memory_has_name_row_and_column():
    columns = {"time [s]": [0.0, 1.0, 2.0], "position [m]": [0.0, numpy.inf, 0.2]}
    for source in (columns, polars.DataFrame(columns)):
        error = refused(lambda source=source: host_sim.read(source, name="run 7"))
        assert (error.file, error.row, error.key) == ("run 7", 2, "position [m]")
    backwards = refused(lambda: host_sim.read({"time [s]": [0.0, 2.0, 1.0], "spool": [0.0, 0.0, 0.1]}, name="run 8"))
    assert (backwards.file, backwards.row, backwards.key) == ("run 8", 3, "time")


def test_what_is_no_column_of_numbers_says_so():
    error = refused(lambda: host_sim.read({"time [s]": [0.0, 1.0], "position [m]": ["a", "b"]}))
    assert "position [m]" in str(error) and error.key == "position [m]"
    error = refused(lambda: host_sim.read({"time [s]": [0.0, 1.0], "position [m]": numpy.zeros((2, 2))}))
    assert "not one-dimensional" in str(error)
    for times, found in [
        (numpy.zeros((2, 2), "M8[ns]"), "not one-dimensional"),
        (numpy.array(["2026-01", "2026-02"], "M8[M]"), "months"),
    ]:
        error = refused(lambda times=times: host_sim.read({"time": times, "position [m]": [0.0, 1.0]}))
        assert found in str(error) and error.key == "time", error
    error = refused(lambda: host_sim.read({"time [s]": [0.0, 1.0], "position": [0.0, 1.0]}))
    assert "has no unit" in str(error) and error.key == "position"
    with pytest.raises(TypeError, match="no recording"):
        host_sim.read(7)


def test_an_error_about_no_file_has_none():
    error = refused(lambda: host_sim.simulate(MACHINE, input="stepp:4V"))
    assert (error.file, error.row, error.key) == (None, None, "input")
    error = refused(lambda: host_sim.simulate(MACHINE, TRAIN[0], arithmetic="double"))
    assert error.key == "arithmetic" and "expected fixed or float" in str(error)
    error = refused(lambda: host_sim.Machine(MACHINE)["valve.gain"])
    assert "valve.gain" in str(error)


def test_an_absent_file_is_named():
    error = refused(lambda: host_sim.read("absent.csv"))
    assert (error.file, error.row, error.key) == ("absent.csv", None, None)
    error = refused(lambda: host_sim.diagnose("absent.toml", TRAIN))
    assert error.file == "absent.toml"


def test_a_recording_is_not_counted_twice():
    error = refused(lambda: host_sim.diagnose(MACHINE, TRAIN[:2], TRAIN[0]))
    assert "hold the same recording" in str(error)


def test_a_value_out_of_range_is_refused_as_in_a_file():
    error = refused(lambda: host_sim.Machine(MACHINE).replaced({"cylinder.stroke_m": -1.0}))
    assert error.key == "cylinder.stroke_m"
    machine = host_sim.Machine(MACHINE).replaced({"cylinder.stroke_m": 0.5})
    assert machine["cylinder.stroke_m"] == 0.5
    assert machine.describe("cylinder.stroke_m").unit == "m"
