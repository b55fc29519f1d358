"""What FMPy makes of an FMU: `validate FMU`, `simulate FMU CSV STEP`, `states FMU`."""

import contextlib
import csv
import shutil
import sys

import numpy
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

OUTPUTS = ["spool", "position", "velocity", "pressure_a", "pressure_b", "flow", "force"]


def validate(fmu):
    for problem in validate_fmu(fmu):
        print(problem)


def simulate(fmu, recording, step):
    """One line a communication point: the time and all outputs, with every digit."""
    with open(recording, newline="") as file:
        header, *rows = csv.reader(file)
    column = [name.split(" ")[0] for name in header].index("command")
    time = [float(row[0]) for row in rows]
    command = [float(row[column]) for row in rows]
    # Held from row to row: two points where it jumps.
    points = [(time[0], command[0])]
    for at, before, after in zip(time[1:], command, command[1:]):
        if before != after:
            points += [(at, before), (at, after)]
    points.append((time[-1], command[-1]))
    # It speaks of inputs that keep their start values.
    with contextlib.redirect_stdout(sys.stderr):
        result = simulate_fmu(
            fmu,
            validate=True,
            fmi_type="CoSimulation",
            start_time=time[0],
            stop_time=time[-1],
            output_interval=float(step),
            input=numpy.array(points, dtype=[("time", float), ("command", float)]),
            output=OUTPUTS,
        )
    for row in result:
        print(*(repr(float(value)) for value in row))


def states(fmu):
    """The position after a step: once, again from the state before it, and again from that state as bytes."""
    described = read_model_description(fmu)
    reference = {variable.name: variable.valueReference for variable in described.modelVariables}
    folder = extract(fmu)
    try:
        slave = FMU3Slave(
            guid=described.guid,
            unzipDirectory=folder,
            modelIdentifier=described.coSimulation.modelIdentifier,
            instanceName="drive",
        )
        told = []
        slave.instantiate(logMessage=lambda environment, status, category, message: told.append(message.decode()))

        def begin():
            slave.enterInitializationMode()
            slave.setFloat64([reference["command"]], [5.0])
            slave.exitInitializationMode()

        def step():
            slave.doStep(0.1, 0.05)
            print(repr(slave.getFloat64([reference["position"]])[0]))

        begin()
        slave.doStep(0.0, 0.1)
        state = slave.getFMUState()
        written = slave.serializeFMUState(state)
        step()
        slave.setFMUState(state)
        slave.freeFMUState(state)
        step()
        slave.reset()
        begin()
        state = slave.deserializeFMUState(written)
        slave.setFMUState(state)
        slave.freeFMUState(state)
        step()
        try:
            slave.doStep(0.15, 0.0015)
        except Exception:
            print(told[-1])
        slave.terminate()
        slave.freeInstance()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


{"validate": validate, "simulate": simulate, "states": states}[sys.argv[1]](*sys.argv[2:])
