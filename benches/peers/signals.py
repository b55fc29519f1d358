"""The peers' signals and what is accurate under them: says in a line of JSON the signals, the start of each drive and the reference's rows, then
answers each line `drive parameter factor substeps,...` with the reference's rows of the drive that is changed so, and whether RK4 in C float with
that many substeps is accurate on it.  Everything is theirs (`common.py` in the folder of the first argument); here it is only called."""
import sys

sys.path.insert(0, sys.argv[1])

import json
import math

import numpy

from common import DRIVES, SIGNALS, Host, accurate, error, reference, rest

CHANGED = {
    "viscous friction": lambda d, f: dict(D=d["D"] * f),
    "bulk modulus": lambda d, f: dict(ca=d["ca"] * f, cb=d["cb"] * f),
    "moving mass": lambda d, f: dict(m=d["m"] / f),
    "flow": lambda d, f: dict(kq=d["kq"] * f, qmax=d["qmax"] * f),
}
JUDGED = ("random", "step 10 V")


def judged(run):
    """Position and both pressures of a run, row by row."""
    return run[:, [1, 3, 4]].astype(float).tolist()


print(json.dumps(dict(
    signals={signal: volts.tolist() for signal, volts in SIGNALS.items()},
    start={drive: rest(of) for drive, of in DRIVES.items()},
    references={drive: {signal: judged(reference(drive, signal)) for signal in SIGNALS} for drive in DRIVES},
)), flush=True)
for line in sys.stdin:
    drive, parameter, factor, substeps = line.rstrip("\n").split("\t")
    changed = DRIVES[drive] | CHANGED[parameter](DRIVES[drive], float(factor))
    # As many substeps of a time that the change makes shorter; where they do not bear it either, there is no reference.
    exact = Host(changed, 200 * math.ceil(float(factor)), "double")
    references = {signal: exact(SIGNALS[signal]) for signal in JUDGED}
    if not all(numpy.all(numpy.isfinite(run)) for run in references.values()):
        print(json.dumps(dict(references=None, borne=[])), flush=True)
        continue
    borne = []
    for number in filter(None, substeps.split(",")):
        host = Host(changed, int(number))
        if all(accurate(error(host(SIGNALS[signal]), references[signal])) for signal in JUDGED):
            borne.append(int(number))
    print(json.dumps(dict(references={signal: judged(run) for signal, run in references.items()}, borne=borne)), flush=True)
