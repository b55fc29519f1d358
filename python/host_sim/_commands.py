"""The commands. Each does what the program's command of its name does, and gives the same result.

Python's lock is released while they compute. Ctrl-C ends them. Wherever recordings are expected, one or a list of whatever
:func:`host_sim.read` takes is accepted.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, Union

from . import _native
from ._machine import Machine
from ._made import tells_its_making
from ._recordings import Source, read, read_all
from ._results import Comparison, Diagnosis, Fit, Inspection, Plan, Simulation

Drive = Union[Machine, str, "os.PathLike[str]"]
Recordings = Union[Source, Sequence[Source]]
Arithmetic = Literal["fixed", "float"]
_EXCITATIONS = ("zero", "step", "steps", "sweep", "random", "triangle")


def _machine(machine: Drive) -> Machine:
    return machine if isinstance(machine, Machine) else Machine(machine)


@tells_its_making
def inspect(
    recordings: Recordings,
    machine: Drive | None = None,
    *,
    map: Mapping[str, str] | None = None,
    threads: int | None = None,
) -> Inspection:
    """Says what recordings hold, which links of the drive they can test, and what is missing to test the others.

    Args:
        recordings: one or several.
        machine: with it also against its dead zone, stroke and supply.
        map: which column holds a signal: ``{"position": "Kolbenweg [mm]"}``.
        threads: how many threads compute; None for as many as there are cores. The result does not depend on it.
    """
    drive = None if machine is None else _machine(machine)
    native = None if drive is None else drive._inner
    return Inspection(_native.inspect(read_all(recordings, map, drive), native, threads))


def simulate(
    machine: Drive,
    recording: Source | None = None,
    *,
    input: str | None = None,
    arithmetic: Arithmetic = "fixed",
    tick_ms: float | None = None,
    map: Mapping[str, str] | None = None,
    threads: int | None = None,
) -> Simulation:
    """Simulates a recording, or the answer to an input signal from mid-stroke at rest.

    Args:
        machine: the drive, or its machine file.
        recording: what drives the model.
        input: instead, a signal at the command, in V or mA as the machine counts: ``"step:4V"``, ``"sweep:6.5V,0.4Hz,5Hz,4s"``, ``"random:10V,0.08s,0.5s,4s,seed=1"``.
        arithmetic: ``fixed`` is what the controller computes, ``float`` double precision.
        tick_ms: step of the model in ms: 0.5, 1 or 2; without it 1, or 0.5 for recordings faster than that, or 2 below 50 Hz.
        map: which column holds a signal.
        threads: how many threads compute; the result does not depend on it.
    """
    if isinstance(recording, str) and recording.partition(":")[0] in _EXCITATIONS and not Path(recording).exists():
        raise TypeError(f"recording: {recording!r} is an input signal and not a file; expected input={recording!r}")
    drive = _machine(machine)
    given = None if recording is None else read(recording, map=map, machine=drive)._inner
    return Simulation(_native.simulate(drive._inner, given, input, arithmetic, tick_ms, threads))


@tells_its_making
def compare(
    machine: Drive,
    recordings: Recordings,
    *,
    judge: Sequence[str] = (),
    arithmetic: Arithmetic = "fixed",
    tick_ms: float | None = None,
    map: Mapping[str, str] | None = None,
    threads: int | None = None,
) -> Comparison:
    """Compares recordings with the model, end to end and link by link.

    Args:
        machine: the drive, or its machine file.
        recordings: one or several.
        judge: judge by these signals only: ``["spool", "pressure_a"]``.
        arithmetic: ``fixed`` is what the controller computes, ``float`` double precision.
        tick_ms: step of the model in ms: 0.5, 1 or 2.
        map: which column holds a signal.
        threads: how many threads compute; the result does not depend on it.
    """
    drive = _machine(machine)
    given = read_all(recordings, map, drive)
    return Comparison(_native.compare(drive._inner, given, list(judge), arithmetic, tick_ms, threads))


@tells_its_making
def fit(
    machine: Drive,
    train: Recordings,
    *,
    holdout: Recordings = (),
    judge: Sequence[str] = (),
    tick_ms: float | None = None,
    map: Mapping[str, str] | None = None,
    as_recorded: bool = False,
    threads: int | None = None,
) -> Fit:
    """Refits a drive's base parameters to recordings.

    The parameters of ``[fit.sigma]`` move, each around its nominal value by its standard deviation; without that table the
    usually uncertain ones that the file gives, by a tenth.

    Args:
        machine: the drive, or its machine file.
        train: the recordings to fit to.
        holdout: recordings that take no part in the fit, to judge it by.
        judge: judge by these signals only.
        tick_ms: step of the model in ms: 0.5, 1 or 2.
        map: which column holds a signal.
        as_recorded: take the recordings as they are, even where a channel is certainly reversed, exchanged or in another unit.
        threads: how many threads compute; the result does not depend on it.
    """
    drive = _machine(machine)
    given, held_out = read_all(train, map, drive), read_all(holdout, map, drive)
    return Fit(_native.fit(drive._inner, given, held_out, list(judge), tick_ms, as_recorded, threads))


@tells_its_making
def diagnose(
    machine: Drive,
    train: Recordings = (),
    holdout: Recordings = (),
    *,
    since: bool = False,
    judge: Sequence[str] = (),
    tick_ms: float | None = None,
    time_limit_s: float = 300.0,
    map: Mapping[str, str] | None = None,
    as_recorded: bool = False,
    threads: int | None = None,
) -> Diagnosis:
    """Finds what a model lacks: where, which physics, and how much better it follows with it.

    Args:
        machine: the drive, or its machine file; or a folder with machine.toml, train-* and holdout-*.
        train: the recordings that make the choice, each left out in turn.
        holdout: the recordings that are opened once after it, to confirm or veto.
        since: whether the effects that ``machine`` holds may have become more or less: what has changed since it was written.
        judge: judge by these signals only.
        tick_ms: step of the model in ms: 0.5, 1 or 2.
        time_limit_s: what the search may take, in s on two cores. It is counted in simulated ticks and not by a clock: the same
            input gives the same answer everywhere.
        map: which column holds a signal.
        as_recorded: take the recordings as they are, even where a channel is certainly reversed, exchanged or in another unit.
        threads: how many threads compute; the result does not depend on it.
    """
    if not isinstance(machine, Machine) and Path(machine).is_dir():
        if train or holdout:
            raise TypeError("train, holdout: beside a folder, which has its own; expected a machine file, or the folder alone")
        folder = Path(machine)
        train, holdout = _native.listed(folder, "train-"), _native.listed(folder, "holdout-")
        machine = folder / "machine.toml"
    drive = _machine(machine)
    trained, held_out = read_all(train, map, drive), read_all(holdout, map, drive)
    limits = (tick_ms, float(time_limit_s), as_recorded, threads)
    return Diagnosis(_native.diagnose(drive._inner, trained, held_out, since, list(judge), *limits))


def plan(
    machine: Drive,
    sensors: Sequence[str] = (),
    *,
    input: str | None = None,
    recording: Source | None = None,
    largest_v: float | None = None,
    longest_s: float = 20.0,
    with_load: bool = False,
    map: Mapping[str, str] | None = None,
    threads: int | None = None,
) -> Plan:
    """Says before recording which effects could be seen and told apart, and lays out the excitation that separates most.

    Args:
        machine: the drive, or its machine file.
        sensors: the sensors at hand, each with the standard deviation of its noise: ``["position:0.05mm", "pressure_a:0.2bar"]``;
            the usual noise without. With ``recording`` they may be left out.
        input: an excitation that is judged beside the best one, such as ``"steps:4V"``.
        recording: the same, recorded.
        largest_v: the largest command, V; without it that of the excitation at hand, or 10.
        longest_s: the longest excitation, s.
        with_load: the rig can load the rod from outside: tests under load count.
        map: which column holds a signal.
        threads: how many threads compute; the result does not depend on it.
    """
    if not sensors and recording is None:
        raise TypeError("sensors: none; expected those at hand, such as ['position:0.05mm', 'spool'], or a recording")
    if input is not None and recording is not None:
        raise TypeError("input: beside a recording; expected one excitation at hand")
    drive = _machine(machine)
    given = None if recording is None else read(recording, map=map, machine=drive)._inner
    at_hand = (input, given)
    return Plan(_native.plan(drive._inner, list(sensors), at_hand, largest_v, longest_s, with_load, threads))
