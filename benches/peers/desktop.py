"""The peers' desktop opponents, one run at a time: says in a line of JSON what there is, then answers each line `drive number` with the seconds
a tick took.  Everything that is timed is theirs (`bench_desktop.py` in the folder of the first argument); here it is only called."""
import sys

sys.path.insert(0, sys.argv[1])

import json
import subprocess

import numba
import numpy
import scipy

import bench_desktop as theirs
from common import DRIVES, Host, accurate, error, reference, smallest


def peak_kb():
    return int(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))


def opponents(drive):
    """Name: (what runs it once, how often it is timed in a round, how).  The list is that of their main()."""
    substeps = smallest(drive, "double")[0]

    def c(sub, real="double"):
        host = Host(drive, sub, real)
        out = numpy.empty((theirs.N, 5), host.dtype)
        return lambda: host(theirs.U32, out)

    packed = theirs.nb.pack(DRIVES[drive])
    found = {
        "RK4 C f64": (c(substeps), 20, f"S={substeps}"),
        "RK4 C f32": (c(substeps, "float"), 20, f"S={substeps}"),
        "RK4 Numba": (lambda: theirs.nb.simulate(packed, theirs.U, theirs.DT, substeps)[1:], 20, f"S={substeps}"),
    }
    for method in ("LSODA", "Radau"):
        _, rtol, limit, pieces, calls, *_ = theirs.search(drive, method)[0]
        how = f"rtol {rtol:g}, max_step {limit:g}, {'a solve per command step' if pieces else 'one solve'}, {calls} evaluations"
        found[f"SciPy {method}, tuned"] = (theirs.Scipy(drive, method, "numba", rtol, limit, pieces), 1, how)
        found[f"SciPy {method}, as usual"] = (theirs.usual(drive, method), 1, "rtol 1e-6, max_step 0.001, np.interp, NumPy")
    return found


def of_c_kb():
    """Most memory of a process that imports NumPy and runs C once."""
    program = """
import sys
sys.path.insert(0, sys.argv[1])
from common import SIGNALS, Host
Host("press", 2)(SIGNALS["random"])
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""
    return int(subprocess.run([sys.executable, "-c", program, sys.argv[1]], check=True, capture_output=True, text=True).stdout)


theirs.nb.simulate(theirs.nb.pack(DRIVES["press"]), theirs.U, theirs.DT, 2)
with_numba_kb = peak_kb()
known = {drive: opponents(drive) for drive in ("press", "heavy")}
said = {drive: [] for drive in known}
for drive, all_of in known.items():
    for name, (run, _, how) in all_of.items():
        y, p = error(run(), reference(drive, "random"))
        said[drive].append(dict(name=name, how=how, position=float(y), pressure=float(p), accurate=bool(accurate((y, p)))))
print(json.dumps(dict(
    versions=f"numpy {numpy.__version__}, scipy {scipy.__version__}, numba {numba.__version__}",
    opponents=said,
    peak_kb=dict(c=of_c_kb(), numba=with_numba_kb, all=peak_kb()),
)), flush=True)
for line in sys.stdin:
    drive, number = line.split()
    run, times, _ = list(known[drive].values())[int(number)]
    # A few runs at a time: between two turns of other programs.
    print(json.dumps(min(theirs.clock(run, min(times, 4)) for _ in range(times)) / theirs.N), flush=True)
