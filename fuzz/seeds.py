"""What the search begins with: small files of every kind that the readers know, as the tools that people use write them.

    python -m venv env && env/bin/pip install scipy asammdf pyarrow openpyxl
    env/bin/python seeds.py

It writes corpus/<target>/seed-*; what the search has found stands beside them and is left alone. The seeds of `coefficients` and of
`step_*` are in the tests' own coding and written by `RENEW=1 cargo test -p system-tests --test anything`.
"""

import gzip
import io
import struct
import zipfile
import zlib
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from asammdf import MDF, Signal
from asammdf.blocks.conversion_utils import from_dict
from openpyxl import Workbook
from scipy.io import savemat

here = Path(__file__).parent / "corpus"


def seed(target, name, content):
    folder = here / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"seed-{name}").write_bytes(content.encode() if isinstance(content, str) else content)


def written(write):
    """The bytes that `write` writes to a file."""
    path = here / "written"
    write(path)
    content = path.read_bytes()
    path.unlink()
    return content


rows = 5
k = np.arange(rows)
time_s, spool, position_mm = k / 256, k / 8 - 0.25, 150.0 + k

# Text.
seed("csv", "plain", "time [s],command [V],position [mm]\n0,0,150\n0.001,2.5,150.5\n0.002,-1e1,151\n")
seed("csv", "comma", "\ufefftime [ms];command [V];\"x [mm]\"\r\n0;0;150,5\r\n1;-0,5;151\r\n2;,5;\r\n3;1;152\r\n")
seed("csv", "tab", "# bench 3\n\ntime [s]\tspool\ts\t\n0\t0,5\t5\t\n1\t\t6\t\n1\t1\t7\tx\n2\t1\t8\t\n")
seed("csv", "quoted", 'time [min],"pressure_a [bar]","a, ""b"" [x]"\n0,1,"2,3"\n1,2,"""\n')
seed("csv", "unit", "time [h],oil_temperature [degF],flow [l/min],force [kN],current [%]\n0,70,1,2,3\n1,80,2,3,4\n")
seed("csv", "ragged", "time [s],position [furlong]\n0,1\n1,2,3\n")
seed("csv", "number", "time [s],position [m]\n0,1e400\n1,nan\n-1,0x10\n1e-320,-.5e+1\n")
seed("csv", "far", "time [s],position [m]\n-1.7e308,-1.7e308\n1.7e308,1.7e308\n")

# TwinCAT Scope.
head = "Name\tBench\nFile\tb.svdx\nStarttime of export\t133000000000000000\n\n"
names = "Name\tcommand [V]\tx\tName\toil_temperature [°C]\nSymbolComment\t\t\tSymbolComment\t\nData-Type\tREAL64\tREAL32\tData-Type\tREAL32\n"
more = "SampleTime[ms]\t1\t1\tSampleTime[ms]\t2\nSymbolName\tMAIN.u\tMAIN.x\tSymbolName\tMAIN.T\nUnit\tV (Voltage)\t(None)\tUnit\t(None)\n\n"
body = "0\t0,5\t150\t0,5\t40\n1\t1\t151\t2,5\t41\n1\t1\t152\t4\t42\n2\t1,5\t153\t\t\n3\t2\t\t\t\nEOF\n"
seed("twincat", "two-clocks", head + names + more + body)
seed("twincat", "bare", "Name;spool;Name;position [mm]\nSampleTime[ms];1;SampleTime[ms];1\n0;0,1;0;1\n1;0,2;1;2\n2;9;2;3\n")
seed("twincat", "stamps", "Name\tspool\nData-Type\tREAL\n132959733843760000\t1\n132959733843770000\t1\n")
seed("twincat", "far", "Name\tspool\tName\tpressure_a [Pa]\nData-Type\tR\tData-Type\tR\n1\t1\t0\t-1.7e308\n2\t2\t4\t1.7e308\n3\t3\t\t\n")

# MATLAB.
vectors = {
    "time_s": time_s.reshape(-1, 1),
    "command_V": k.astype(np.int8).reshape(-1, 1),
    "spool": spool.astype(np.float32).reshape(1, -1),
    "x": position_mm.astype(np.int64),
    "remark": "cold",
    "cell": np.array([1, "a"], dtype=object),
    "complex": np.array([1j]),
    "matrix": np.eye(2),
}
seed("mat", "vectors", written(lambda path: savemat(path, vectors, appendmat=False)))
seed("mat", "structure", written(lambda path: savemat(path, {"run": {"time_s": time_s, "position_mm": position_mm}}, appendmat=False)))
timed = {"position_mm": {"Time": time_s, "Data": position_mm}, "spool": {"time": time_s[1:], "values": spool[1:]}}
seed("mat", "timed", written(lambda path: savemat(path, timed, appendmat=False)))
signals = np.array([(spool, "spool"), (position_mm, "x [mm]")], dtype=[("values", object), ("label", object)]).reshape(1, -1)
seed("mat", "simulink", written(lambda path: savemat(path, {"out": {"time": time_s, "signals": signals}}, appendmat=False)))
plain = written(lambda path: savemat(path, {"time_s": time_s, "position_mm": position_mm}, appendmat=False))
packed = plain[:128]
rest = plain[128:]
while rest:
    length = 8 + struct.unpack_from("<I", rest, 4)[0]
    # Stored and not deflated, so that what is changed in it stays readable.
    inner = zlib.compress(rest[:length], 0)
    packed += struct.pack("<II", 15, len(inner)) + inner
    rest = rest[length:]
seed("mat", "packed", packed)
seed("mat", "new", b"MATLAB 7.3 MAT-file, Platform")
seed("mat", "big-endian", plain[:126] + b"MI" + plain[128:])

# MDF 4.
raw = (400 + k).astype(np.uint16)
for name, conversion in {
    "linear": from_dict({"a": 0.125, "b": -5.0}),
    "rational": from_dict({"P1": 0.0, "P2": 2.0, "P3": 1.0, "P4": 0.0, "P5": 0.0, "P6": 4.0}),
    "table": from_dict({"raw_0": 400.0, "phys_0": 1.0, "raw_1": 404.0, "phys_1": 2.0, "interpolation": True}),
}.items():
    def one(path):
        with MDF(version="4.10") as mdf:
            mdf.header.start_time = datetime(2024, 5, 6, 7, 8, 9, tzinfo=timezone.utc)
            mdf.append([
                Signal(spool.astype(np.float32), time_s, name="spool", unit="1"),
                Signal(raw, time_s, name="oil_temperature", unit="°C", conversion=conversion),
            ])
            mdf.append([Signal(position_mm[1:], time_s[1:], name="Bench.x\\XCP:1", unit="mm")])
            mdf.save(path, overwrite=True, compression=0)
        path.with_suffix(".mf4").rename(path)
    seed("mdf4", name, written(one))


class Blocks:
    """A file block by block: places first, then links."""

    def __init__(self):
        self.bytes = bytearray(b"MDF     4.10    seeds   ".ljust(64, b"\0"))

    def add(self, name, links, data):
        at = len(self.bytes)
        self.bytes += b"##" + name.encode() + struct.pack("<IQQ", 0, 24 + 8 * len(links) + len(data), len(links))
        self.bytes += b"".join(struct.pack("<Q", link) for link in links) + data
        self.bytes += b"\0" * (-len(self.bytes) % 8)
        return at

    def text(self, text):
        return self.add("TX", [], text.encode() + b"\0")

    def channel(self, following, name, unit, kind=0, sync=0, data_type=0, bit=0, byte=0, bits=8, flags=0, mark=0):
        data = struct.pack("<BBBBIIII", kind, sync, data_type, bit, byte, bits, flags, mark) + b"\0" * 48
        return self.add("CN", [following, 0, self.text(name), 0, 0, 0, self.text(unit), 0], data)


def grouped(data_of, record_id=0, bit=4, bits=12):
    blocks = Blocks()
    blocks.add("HD", [0] * 6, b"\0" * 32)
    signal = blocks.channel(0, "spool", "1", data_type=2, bit=bit, byte=1, bits=bits, flags=2, mark=1)
    clock = blocks.channel(signal, "t", "s", kind=2, sync=1, byte=0, bits=8)
    group = struct.pack("<QQHHIII", record_id, rows, 0, 0, 0, 3, 1)
    group = blocks.add("CG", [0, clock, blocks.text("Bench"), 0, 0, 0], group)
    data = data_of(blocks)
    first = blocks.add("DG", [0, group, data, 0], struct.pack("<B7x", 1 if record_id else 0))
    struct.pack_into("<Q", blocks.bytes, 64 + 24, first)
    return bytes(blocks.bytes)


records = [bytes([i, 16 * i, i, 2 * (i == 3)]) for i in range(rows)]
plain_records = b"".join(records)


def zipped(blocks, plain, kind):
    if kind:
        plain = b"".join(plain[i::4] for i in range(4))
    inner = zlib.compress(plain, 0)
    return blocks.add("DZ", [], struct.pack("<2sBBIQQ", b"DT", kind, 0, 4 * kind, len(plain), len(inner)) + inner)


def listed(blocks):
    parts = [blocks.add("DT", [], plain_records[:6]), zipped(blocks, plain_records[6:], 0)]
    second = blocks.add("DL", [0, parts[1]], struct.pack("<B3xI", 0, 1))
    return blocks.add("HL", [blocks.add("DL", [second, parts[0]], struct.pack("<B3xI", 0, 1))], b"\0" * 8)


seed("mdf4", "bits", grouped(lambda blocks: blocks.add("DT", [], plain_records)))
# Their sum is 4, in 32 bits.
seed("mdf4", "bits-without-end", grouped(lambda blocks: blocks.add("DT", [], plain_records), bit=5, bits=0xFFFFFFFF))
seed("mdf4", "list", grouped(listed))
seed("mdf4", "transposed", grouped(lambda blocks: zipped(blocks, plain_records, 1)))
seed("mdf4", "numbered", grouped(lambda blocks: blocks.add("DT", [], b"".join(b"\x07" + r for r in records)), record_id=7))
seed("mdf4", "old", b"MDF     3.30    seeds".ljust(64, b"\0"))
seed("mdf4", "open", b"UnFinMF 4.10    seeds".ljust(64, b"\0"))

# Parquet. Without the schema of Arrow, which is long and not read.
numbers = {"time [s]": time_s, "spool": spool.astype(np.float32), "x [mm]": pa.array([150, None, 151, 152, 153], pa.int32())}
for name, options in {
    "snappy": {},
    "plain": {"compression": "none", "use_dictionary": False},
    "pages": {"compression": "none", "use_dictionary": False, "data_page_version": "2.0", "row_group_size": 2},
    "split": {"compression": "none", "use_dictionary": False, "column_encoding": {"time [s]": "BYTE_STREAM_SPLIT", "x [mm]": "DELTA_BINARY_PACKED"}},
    "zstd": {"compression": "zstd"},
}.items():
    seed("parquet", name, written(lambda path: pq.write_table(pa.table(numbers), path, store_schema=False, write_statistics=False, **options)))
others = {"time": pa.array(k * 1000, pa.timestamp("us")), "spool": pa.array(spool), "on": pa.array(k > 2), "list": pa.array([[1]] * rows), "text": ["a"] * rows}
seed("parquet", "stamps", written(lambda path: pq.write_table(pa.table(others), path, store_schema=False, write_statistics=False)))

# Workbooks, another archive, and a packed text.
def workbook(sheets):
    book = Workbook()
    book.remove(book.active)
    for name, lines in sheets.items():
        sheet = book.create_sheet(name)
        for line in lines:
            sheet.append(line)
    content = io.BytesIO()
    book.save(content)
    return content.getvalue()


plain = [["time [s]", "x [mm]", "s", "remark"]] + [[row * 0.5, 150 + row, 5.5, "a, b"] for row in range(4)]
dated = [["# bench"], ["time", "x"], [None, "mm"]] + [[datetime(2024, 5, 6, 7, 8, row), row] for row in range(3)]
seed("xlsx", "plain", workbook({"run": plain}))
seed("xlsx", "dated", workbook({"notes": [["made by", "somebody"]], "run": dated}))
seed("xlsx", "two", workbook({"run 1": plain, "run 2": plain}))
archive = io.BytesIO()
with zipfile.ZipFile(archive, "w") as file:
    file.writestr("content.xml", "<x/>")
seed("xlsx", "archive", archive.getvalue())
seed("csv", "packed", gzip.compress(b"time [s];x [mm]\n0;1,5\n1;2,5\n", mtime=0))
seed("csv", "above", "sep=;\ntime;x;s;\ns;mm;;\n0;1,5;5;\n1;NaN;5;\n2;2,5;5")
seed("csv", "dates", "x [mm];time\n1,5;2024-05-06T07:08:09,125\n2,5;06.05.2024 07:08:10,125\n3,5;2024-05-06 07:08:11Z\n")
seed("mat", "version4", written(lambda path: savemat(path, {"time_s": time_s, "x": np.arange(rows)}, format="4", appendmat=False)))

# Machine files.
seed("machine_file", "valve", """name = "press" # bench 3
[supply]
pressure_pa = 7.0e6
[valve]
gain_per_v = 0.0559
time_constants_s = [0.018, 0.0279]
[cylinder]
area_a_m2 = 3.117e-3
area_b_m2 = 1.861e-3
[load]
source = "recorded-pressures"
[effects.internal-leakage]
conductance_m3_per_s_pa = 2.0e-12
[effects.stribeck-friction]
[channels]
position = "Kolbenweg [mm]"
spool = { column = "s", zero = 5, full = 5.0 }
[fit.sigma]
"valve.gain_per_v" = 0.01
""")
seed("machine_file", "pump", "[pump]\n[directional_valve]\n[cylinder]\narea_a_m2 = 2e-3\narea_b_m2 = 1e-3\nvolume_a_m3 = 1_0e-4\n")
seed("machine_file", "inline", "supply = {pressure_pa=7e6}\nvalve.gain_per_v = 1\nvalve.x = 1\n[[cylinder]]\narea_a_m2 = nan\n")
seed("machine_file", "text", 'name = """\n</script>"\\u0000\\U0010FFFF"""\nchannels.position = \'\'\n[supply]\npressure_pa = -inf\n[valve]\n[cylinder]\n')

# What the recorder streams: kind, length, payload, as the second half of the target takes them.
def message(kind, payload):
    return bytes([kind, len(payload)]) + payload


header = message(1, struct.pack("<BBIIII", 1, 2, 1_000_000, 0xFFFFFFFE, 4, 1) + b"press")
channels = b"".join(
    message(2, struct.pack("<BdB", number, step, len(name)) + name + unit)
    for number, (step, name, unit) in enumerate([(1e-3, b"command", b"V"), (1e-5, b"position", b"m")])
)
data = message(3, struct.pack("<I", 0xFFFFFFFE) + struct.pack("<8h", 1, 2, 3, -32768, 5, 6, 7, 8))
seed("frames", "whole", header + channels + data + message(4, struct.pack("<I", 4)))
seed("frames", "twice", header + data + header + channels)
seed("frames", "name", header + message(2, struct.pack("<BdB", 0, 1.0, 4) + b'a,"\n' + b"V") + channels[len(channels) // 2:] + data)
seed("frames", "far", header + message(2, struct.pack("<BdB", 0, 1.7e308, 1) + b"a" + b"V") + channels[len(channels) // 2:] + data)
