"""Simulates, compares and diagnoses valve-controlled hydraulic drives against recordings.

    import host_sim

    machine = host_sim.Machine("machine.toml")
    diagnosis = host_sim.diagnose(machine, train=["train-1.csv", "train-2.csv"], holdout=["holdout-1.csv"])
    diagnosis.verdict                 # 'missing-physics', 'nothing-missing' or 'unexplained'
    diagnosis.findings[0].effect      # 'internal-leakage'
    diagnosis.to_dict()               # what `host-sim diagnose --json` writes
    diagnosis                         # in a notebook: the report's page with its charts

Inside, every value is in SI units (m, Pa, m³/s, N, s; pump speed in rev/s, oil temperature in °C, command in V or mA).
Columns of recordings and tables carry their unit in the header: "position [mm]".
"""

from ._commands import compare, diagnose, fit, inspect, plan, simulate
from ._fleet import FleetNight, FleetRun, fleet, fleet_nights, fleet_part
from ._machine import Machine
from ._native import Error, FleetTable, __version__
from ._recordings import Recording, read
from ._results import (
    Comparison,
    Diagnosis,
    Finding,
    Fit,
    Inspection,
    Parameter,
    Plan,
    SignalFit,
    Simulation,
    Table,
)

__all__ = [
    "Comparison",
    "Diagnosis",
    "Error",
    "Finding",
    "Fit",
    "FleetNight",
    "FleetRun",
    "FleetTable",
    "Inspection",
    "Machine",
    "Parameter",
    "Plan",
    "Recording",
    "SignalFit",
    "Simulation",
    "Table",
    "__version__",
    "compare",
    "diagnose",
    "fit",
    "fleet",
    "fleet_nights",
    "fleet_part",
    "inspect",
    "plan",
    "read",
    "simulate",
]
