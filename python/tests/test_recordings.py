"""A recording is the same wherever it comes from."""

from __future__ import annotations

from pathlib import Path

import host_sim
import numpy
import pandas
import polars
import pyarrow
import pyarrow.csv
import pytest
from conftest import CASE, TRAIN

MACHINE = CASE / "machine.toml"
FILE = TRAIN[0]


def arrow() -> pyarrow.Table:
    # The only one of the readers here that rounds every decimal number to the nearest double, as the program does.
    return pyarrow.csv.read_csv(FILE)


def sources() -> dict[str, object]:
    table = arrow()
    arrays = {name: table[name].to_numpy() for name in table.column_names}
    interleaved = numpy.stack(list(arrays.values()), axis=1)
    return {
        "pyarrow": table,
        "a record batch": table.combine_chunks().to_batches()[0],
        "in chunks": pyarrow.concat_tables([table.slice(0, 700), table.slice(700)]),
        "polars": polars.from_arrow(table),
        "pandas": table.to_pandas(),
        "pandas with the time as its index": table.to_pandas().set_index("time [s]"),
        "arrays": arrays,
        "arrays with strides": {name: interleaved[:, index] for index, name in enumerate(arrays)},
        "lists": {name: values.tolist() for name, values in arrays.items()},
        "series": {name: pandas.Series(values) for name, values in arrays.items()},
    }


@pytest.mark.parametrize("kind", sources())
def test_every_source_gives_the_file_s_result(kind):
    recording = host_sim.read(sources()[kind], name=FILE.name)
    from_file = host_sim.read(FILE)
    assert sorted(recording.columns) == sorted(from_file.columns)
    for column in from_file.columns:
        assert (recording[column.signal] == from_file[column.signal]).all(), column
    assert host_sim.compare(MACHINE, recording).to_dict() == host_sim.compare(MACHINE, FILE).to_dict()


def test_a_frame_of_pandas_without_pyarrow_is_read_by_its_arrays():
    class WithoutPyarrow(pandas.DataFrame):
        def __arrow_c_stream__(self, requested_schema=None):
            raise ImportError("pyarrow")

    recording = host_sim.read(WithoutPyarrow(arrow().to_pandas()))
    assert (recording["pressure_a"] == host_sim.read(FILE)["pressure_a"]).all()


def test_a_frame_is_taken_wherever_a_recording_is():
    machine = host_sim.Machine(MACHINE)
    frame = polars.from_arrow(arrow())
    assert host_sim.simulate(machine, frame).to_dict() == host_sim.simulate(machine, FILE).to_dict()
    assert len(host_sim.inspect([frame, FILE]).recordings) == 2


def test_units_stand_in_the_header_behind_the_name_or_beside_it():
    time, position = numpy.arange(3) * 1e-3, numpy.array([125.0, 125.5, 126.0])
    in_header = host_sim.read({"time [s]": time, "position [mm]": position})
    behind = host_sim.read({"time_s": time, "position_mm": position})
    beside = host_sim.read({"time": time, "position": position}, units={"time": "s", "position": "mm"})
    mapped = host_sim.read({"time [s]": time, "Kolbenweg [mm]": position}, map={"position": "Kolbenweg [mm]"})
    for recording in (in_header, behind, beside, mapped):
        assert (recording["position"] == [0.125, 0.1255, 0.126]).all(), recording


def test_numbers_of_every_type_are_read_and_missing_ones_left_out():
    for dtype in ("f4", "i8", "i4", "i2", "i1", "u8", "u4", "u2", "u1"):
        given = {"time [s]": numpy.arange(4, dtype=dtype), "position [m]": numpy.arange(4, dtype=dtype)}
        for source in (given, pyarrow.table(given), polars.DataFrame(given)):
            assert (host_sim.read(source)["position"] == [0, 1, 2, 3]).all(), dtype
    gap = pyarrow.table({"time [s]": [0.0, 1.0, 2.0, 3.0], "position [m]": [0.0, None, 2.0, 3.0]})
    recording = host_sim.read(gap)
    assert len(recording) == 3 and "left out, in row 2" in recording.notes[0]
    assert recording.table().to_dict()["position [m]"] == [0.0, None, 2.0, 3.0]


def test_time_stamps_become_seconds_since_the_first():
    stamps = pandas.date_range("2026-01-01", periods=3, freq="2ms")
    frame = pandas.DataFrame({"time": stamps, "position [m]": [0.0, 0.1, 0.2]})
    for source in (frame, polars.from_pandas(frame), pyarrow.Table.from_pandas(frame)):
        assert host_sim.read(source)["time"].tolist() == [0.0, 0.002, 0.004]


def test_arrow_memory_is_handed_on_without_a_copy():
    simulation = host_sim.simulate(MACHINE, FILE)
    one, other = pyarrow.table(simulation), pyarrow.table(simulation)
    at = [table["position [m]"].chunk(0).buffers()[1].address for table in (one, other)]
    assert at[0] == at[1]
    assert one.to_pydict() == simulation.to_dict()
    assert simulation.to_polars()["position [m]"].to_list() == simulation.to_dict()["position [m]"]
    assert simulation.to_pandas()["position [m]"].tolist() == simulation.to_dict()["position [m]"]


def test_a_recording_is_written_in_every_format(tmp_path: Path):
    recording = host_sim.read(FILE)
    for ending in ("csv", "mat", "parquet"):
        recording.save(tmp_path / f"run.{ending}")
        again = host_sim.read(tmp_path / f"run.{ending}")
        assert (again["position"] == recording["position"]).all(), ending


def test_the_channels_of_the_machine_file_apply_to_frames_too():
    machine = host_sim.Machine.from_toml(MACHINE.read_text() + '\n[channels]\nposition = "Kolbenweg [m]"\n')
    headers = ["Kolbenweg [m]" if header == "position [m]" else header for header in arrow().column_names]
    assert "Kolbenweg [m]" in headers
    one, other = host_sim.compare(machine, arrow().rename_columns(headers)), host_sim.compare(MACHINE, arrow())
    assert one.to_dict() == other.to_dict()
