"""What FMPy makes of an FMU of either version: `validate FMU`, `simulate FMU CSV STEP`, `states FMU`, `refusals FMU OTHER`."""

import contextlib
import csv
import shutil
import sys

import numpy
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
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


class Drive:
    """An instance of an FMU of either version, and what it wrote into the log."""

    def __init__(self, fmu, folder):
        described = read_model_description(fmu)
        self.reference = {variable.name: variable.valueReference for variable in described.modelVariables}
        self.told = []
        self.version = described.fmiVersion
        kind = {"2.0": FMU2Slave, "3.0": FMU3Slave}[self.version]
        self.slave = kind(
            guid=described.guid,
            unzipDirectory=folder,
            modelIdentifier=described.coSimulation.modelIdentifier,
            instanceName="drive",
        )
        if self.version == "2.0":
            logger = fmi2CallbackLoggerTYPE(lambda _, name, status, category, message: self.tell(message))
            self.slave.instantiate(callbacks=fmi2CallbackFunctions(logger=logger))
            self.set, self.get = self.slave.setReal, self.slave.getReal
        else:
            self.slave.instantiate(logMessage=lambda _, status, category, message: self.tell(message))
            self.set, self.get = self.slave.setFloat64, self.slave.getFloat64

    def tell(self, message):
        self.told.append(message.decode())

    def begin(self):
        if self.version == "2.0":
            self.slave.setupExperiment()
        self.slave.enterInitializationMode()
        self.set([self.reference["command"]], [5.0])
        self.slave.exitInitializationMode()

    def position(self):
        return repr(self.get([self.reference["position"]])[0])

    def refused(self, act):
        """The last line of the log after what must not succeed."""
        try:
            act()
        except Exception:
            return self.told[-1]
        raise AssertionError("not refused")


@contextlib.contextmanager
def drive(fmu):
    folder = extract(fmu)
    try:
        drive = Drive(fmu, folder)
        yield drive
        drive.slave.freeInstance()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def states(fmu):
    """The position after a step: once, again from the state before it, and again from that state as bytes."""
    with drive(fmu) as instance:
        slave = instance.slave

        def step():
            slave.doStep(0.1, 0.05)
            print(instance.position())

        instance.begin()
        slave.doStep(0.0, 0.1)
        state = slave.getFMUState()
        written = slave.serializeFMUState(state)
        step()
        slave.setFMUState(state)
        slave.freeFMUState(state)
        step()
        slave.reset()
        instance.begin()
        state = slave.deserializeFMUState(written)
        slave.setFMUState(state)
        slave.freeFMUState(state)
        step()
        slave.terminate()


def refusals(fmu, other):
    """What the log says of a step, of start values and of the state of another drive that are refused."""
    with drive(other) as foreign:
        foreign.begin()
        state = foreign.slave.getFMUState()
        written = foreign.slave.serializeFMUState(state)
        foreign.slave.freeFMUState(state)
    with drive(fmu) as instance:
        start = [instance.reference["position_start"]]
        for beyond in [-0.001, 0.301]:
            print(instance.refused(lambda: instance.set(start, [beyond])))
        instance.set(start, [0.3])
        instance.begin()
        print(instance.refused(lambda: instance.set(start, [0.1])))
        print(instance.refused(lambda: instance.slave.doStep(0.0, 0.0015)))
        print(instance.refused(lambda: instance.slave.deserializeFMUState(written)))
        print(instance.position())
        instance.slave.terminate()


COMMANDS = {"validate": validate, "simulate": simulate, "states": states, "refusals": refusals}
COMMANDS[sys.argv[1]](*sys.argv[2:])
