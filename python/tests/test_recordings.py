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
    recording = host_sim.read(WithoutPyarrow(arrow().to_pandas()))
    assert (recording["pressure_a"] == host_sim.read(FILE)["pressure_a"]).all()


def test_a_frame_is_taken_wherever_a_recording_is():
    machine = host_sim.Machine(MACHINE)
    frame = polars.from_arrow(arrow())
    assert host_sim.simulate(machine, frame).to_dict() == host_sim.simulate(machine, FILE).to_dict()
    assert len(host_sim.inspect([frame, FILE]).recordings) == 2


def test_a_recording_from_memory_looks_at_no_file_whatever_it_is_called(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("run.csv").write_text("time [s],position [mm],secret [A]\n0,1,4\n0.1,2,5\n0.2,3,6\n")
    columns = {"time [s]": [0.0, 0.1, 0.2], "position [mm]": [1.0, 2.0, 3.0], "secret [A]": [7.0, 8.0, 9.0]}
    file = host_sim.inspect("run.csv").to_html()
    assert "no known signal: the model does not use it" in file
    for source in (columns, polars.DataFrame(columns)):
        memory = host_sim.inspect(host_sim.read(source, name="run.csv")).to_html()
        assert "no known signal: the model does not use it" not in memory


def test_the_page_of_a_file_is_the_same_from_another_folder(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("run.csv").write_text("time [s],position [mm],secret [A]\n0,1,4\n0.1,2,5\n0.2,3,6\n")
    found = host_sim.inspect("run.csv")
    here = found.to_html()
    monkeypatch.chdir("/")
    assert found.to_html() == here


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


class WithoutPyarrow(pandas.DataFrame):
    """A frame of pandas where there is no pyarrow: its columns are NumPy's."""

    def __arrow_c_stream__(self, requested_schema=None):
        raise ImportError("pyarrow")


@pytest.mark.parametrize(("unit", "unit_s"), [("s", 1), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("10ms", 0.01), ("m", 60)])
def test_times_of_numpy_are_read_in_every_unit_as_those_of_a_frame(unit: str, unit_s: float):
    counts, position = 1_700_000_000 + numpy.array([0, 2, 5]), numpy.array([0.0, 0.1, 0.2])
    for kind in ("M8", "m8"):
        times = counts.astype(f"{kind}[{unit}]")
        recording = host_sim.read({"time": times, "position [m]": position})
        assert recording["time"].tolist() == [0.0, 2 * unit_s, 5 * unit_s]
        others = [times.astype(f">{kind}[{unit}]"), numpy.repeat(times, 2)[::2]]
        sources = [{"time": other, "position [m]": position} for other in others]
        if unit in ("s", "ms", "us", "ns"):
            # pandas has no other units.
            series = pandas.Series(times)
            sources += [{"time": series, "position [m]": position}, pandas.DataFrame({"time": series, "position [m]": position})]
        for source in sources:
            assert (host_sim.read(source)["time"] == recording["time"]).all()


def test_times_of_a_zone_are_read_without_pyarrow_too():
    stamps = pandas.date_range("2026-03-29 00:59:59.999", periods=3, freq="1ms", tz="Europe/Berlin")
    frame = pandas.DataFrame({"time": stamps, "position [m]": [0.0, 0.1, 0.2]})
    for source in (frame, WithoutPyarrow(frame), {name: frame[name] for name in frame}):
        assert host_sim.read(source)["time"].tolist() == [0.0, 0.001, 0.002]


def test_a_named_index_is_a_column_without_pyarrow_too():
    values = {"position [m]": [0.0, 0.1, 0.2]}
    for index in (
        pandas.Index([0.0, 0.001, 0.002], name="time [s]"),
        pandas.to_timedelta([0, 1, 2], unit="ms").rename("time"),
        pandas.date_range("2026-03-29", periods=3, freq="1ms", name="time"),
    ):
        frame = pandas.DataFrame(values, index=index)
        for source in (frame, WithoutPyarrow(frame)):
            assert host_sim.read(source)["time"].tolist() == [0.0, 0.001, 0.002]


@pytest.mark.parametrize("kind", [">f8", ">f4", ">i4", ">u2", "<i2", "i1", "f2", "g"])
def test_numbers_of_numpy_are_read_in_every_width_and_byte_order(kind: str):
    values = numpy.array([0, 1, 2, 3], dtype=kind)
    read = host_sim.read({"time [s]": values, "position [m]": values})
    assert read["time"].tolist() == read["position"].tolist() == [0.0, 1.0, 2.0, 3.0]


def test_a_masked_number_of_numpy_leaves_its_row_out():
    position = numpy.ma.masked_array([0, 99, 2, 3], mask=[False, True, False, False])
    read = host_sim.read({"time [s]": [0.0, 1.0, 2.0, 3.0], "position [m]": position})
    assert read["position"].tolist() == [0.0, 2.0, 3.0]


def test_a_missing_time_of_numpy_leaves_its_row_out_as_in_a_frame():
    times = numpy.array(["NaT", "2026-01-01T00:00:00", "NaT", "2026-01-01T00:00:01", "2026-01-01T00:00:03"], "M8[ms]")
    columns = {"time": times, "position [m]": numpy.arange(5.0)}
    for source in (columns, pandas.DataFrame(columns)):
        recording = host_sim.read(source)
        assert recording["time"].tolist() == [0.0, 1.0, 3.0]
        assert recording["position"].tolist() == [1.0, 3.0, 4.0]
        assert "2 rows" in recording.notes[0] and "left out, the first in row 1" in recording.notes[0]


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
