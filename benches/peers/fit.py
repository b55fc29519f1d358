"""The peers' refit: says in a line of JSON what there is, then answers `run NAME` with seconds and cost, and `cost V...` (SI, in the order of
`free`) with the cost of those values.  The model, the recordings, the start and the bounds are theirs (`bench_fit.py` in the folder of the
first argument); the residual is that of their main()."""
import sys

sys.path.insert(0, sys.argv[1])

import json
import time

import numpy as np
from scipy.optimize import least_squares

import bench_fit as theirs

KINDS = {
    "trf": dict(method="trf", bounds=(0.3, 3.0), max_nfev=100),
    "lm, no bounds": dict(method="lm", max_nfev=2000),
}


def peak_kb():
    return int(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))


nominal, recordings = theirs.load()
training = [recording for name, recording in recordings.items() if name.startswith("train")]
substeps, _ = theirs.coarsest(nominal, {str(k): recording for k, recording in enumerate(training)})
scale = [np.mean([np.linalg.norm(r[c] - r[c].mean()) for r in training]) for c in (1, 2)]


def residual(theta):
    values, out = theirs.with_theta(nominal, theta), []
    for recording in training:
        run = theirs.run(values, recording, substeps)
        out += [(run[:, 0] - recording[1]) / scale[0], (run[:, 1] - recording[2]) / scale[1]]
    return np.nan_to_num(np.concatenate(out), nan=10.0, posinf=10.0, neginf=-10.0)


def theta_of(values):
    pairs = zip(theirs.FREE, values)
    return np.array([1 + (v - nominal[k]) / 0.05 if k == "offset" else v / nominal[k] for k, v in pairs])


def refit(kind):
    theirs.Counter.sims = 0
    start, computed = time.perf_counter(), time.process_time()
    found = least_squares(residual, np.ones(len(theirs.FREE)), jac="2-point", **KINDS[kind])
    took, computed = time.perf_counter() - start, time.process_time() - computed
    return dict(seconds=took, computed=computed, cost=float(found.cost), simulations=theirs.Counter.sims // len(training))


for kind in KINDS:
    refit(kind)
print(json.dumps(dict(case=theirs.CASE, kinds=list(KINDS), substeps=substeps, rows=sum(len(r[0]) for r in training), peak_kb=peak_kb())), flush=True)
for line in sys.stdin:
    verb, _, rest = line.strip().partition(" ")
    if verb == "run":
        answer = refit(rest)
    else:
        answer = dict(cost=float(0.5 * np.sum(residual(theta_of([float(v) for v in rest.split()])) ** 2)))
    print(json.dumps(answer), flush=True)
