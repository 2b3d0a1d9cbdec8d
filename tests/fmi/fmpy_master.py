"""FMPy as the master: units of plant and renderer are valid and give the ticks of `enamel push` bit for bit.

    python fmpy_master.py ENAMEL SOURCE      # the command-line tool; the project's folder
"""
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

TOOL, SOURCE = sys.argv[1], Path(sys.argv[2])
DEVICES = SOURCE / "data/devices"


class Unit:
    def __init__(self, path, folder):
        problems = validate_fmu(str(path))  # schema, then the standard's rules
        assert not problems, problems
        self.description = read_model_description(str(path), validate=True)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.slave = FMU3Slave(
            guid=self.description.guid,
            unzipDirectory=extract(str(path), str(folder)),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=path.stem,
        )
        self.slave.instantiate()

    def begin(self):
        self.slave.enterInitializationMode(startTime=0.0)
        self.slave.exitInitializationMode()

    def size(self, name):
        dimensions = self.variables[name].dimensions
        return int(dimensions[0].start) if dimensions else 1

    def get(self, name):
        return list(self.slave.getFloat64([self.variables[name].valueReference], nValues=self.size(name)))

    def set(self, name, values):
        self.slave.setFloat64([self.variables[name].valueReference], values)

    def step(self, i):
        self.slave.doStep(currentCommunicationPoint=i * 1e-3, communicationStepSize=1e-3)

    def end(self):
        self.slave.terminate()
        self.slave.freeInstance()


def enamel(*arguments):
    subprocess.run([TOOL, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


def compare(folder, device, renderer, force, parameters=(), options=()):
    name = f"{device}-{renderer}"
    plant, law, run = folder / f"{name}-plant.fmu", folder / f"{name}.fmu", folder / f"{name}.csv"
    file = DEVICES / f"{device}.toml"
    enamel("fmu", "--device", file, "--output", plant)
    enamel("fmu", "--device", file, "--renderer", renderer, "--output", law,
           *[part for parameter in parameters for part in ("--set", parameter)])
    enamel("push", "--device", file, "--renderer", renderer, "--noise", "0", "--force", force, "--duration", "2",
           "--output", run, *options)
    rows = list(csv.reader(run.open()))
    header = {title.split(" [")[0]: i for i, title in enumerate(rows[0])}
    native = [[float(number) for number in row[: header["gap"]]] for row in rows[1:]]

    device_unit, law_unit = Unit(plant, folder / f"{name}-a"), Unit(law, folder / f"{name}-b")
    device_unit.slave.setBoolean([device_unit.variables["guide"].valueReference], [True])
    device_unit.begin()
    law_unit.begin()
    different, deepest, kept, again = 0, 0.0, None, None
    for i, row in enumerate(native):
        if i == 1020:  # saved during the first impact ...
            kept = device_unit.slave.getFMUState(), law_unit.slave.serializeFMUState(law_unit.slave.getFMUState())
        if i == 1060 and again is None:  # ... and restored once
            again = device_unit.get("position")
            device_unit.slave.setFMUState(kept[0])
            law_unit.slave.setFMUState(law_unit.slave.deserializeFMUState(kept[1]))
            for j in range(1020, 1060):
                tick(device_unit, law_unit, j, force)
            assert device_unit.get("position") == again
        position, velocity = device_unit.get("position"), device_unit.get("velocity")
        different += position != row[header["x"] : header["z"] + 1] or velocity != row[header["vx"] : header["vz"] + 1]
        deepest = min(deepest, position[2])
        tick(device_unit, law_unit, i, force)
    device_unit.end()
    law_unit.end()
    print(f"{name}: {len(native)} ticks, {different} of them different; {-1e6 * deepest:.1f} um deep")
    assert len(native) == 2000 and different == 0 and deepest < 0.0


def tick(device, law, i, force):
    for name in ("q", "rates", "applied"):
        law.set(name, device.get(name))
    device.set("torque", law.get("torque"))
    device.set("force", [-0.0, -0.0, -float(force) if i >= 1000 else -0.0])
    law.step(i)
    device.step(i)


with tempfile.TemporaryDirectory() as folder:
    folder = Path(folder)
    compare(folder, "tau-nominal", "hold", 12, ["release=off"], ["--release", "off"])
    compare(folder, "tau-nominal", "position-control", 12)
    compare(folder, "delta", "position-control", 3)
    compare(folder, "tau-nominal", "impedance", 3, ["stiffness=500"], ["--stiffness", "500"])
    scene = folder / "scene.fmu"
    enamel("fmu", "--device", DEVICES / "tau-nominal.toml", "--renderer", "position-control", "--scene",
           SOURCE / "data/scenes/molar.toml", "--output", scene)
    unit = Unit(scene, folder / "scene")
    unit.begin()
    unit.end()
print("FMPy agrees")
