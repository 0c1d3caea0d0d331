"""The rig that is evaluated before all others leaves no kernel to be compiled while somebody drags a sensor."""

import subprocess
import sys

from tests.waiting import TIMEOUT_S

SCRIPT = """
import importlib, pkgutil
import riglens.core.kernels
from riglens.core.engine.engine import Engine
from riglens.core.engine.warm_up import warm_up
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.presets import preset
from tests.core.builders import field_of, grid_of


def compiled():
    names = [found.name for found in pkgutil.walk_packages(riglens.core.kernels.__path__, "riglens.core.kernels.")]
    things = [thing for name in names for thing in vars(importlib.import_module(name)).values()]
    return {thing.py_func.__qualname__: code_of(thing) for thing in things if hasattr(thing, "py_func")}


def code_of(kernel):
    return {types: made.library.is_only_linked for types, made in kernel.overloads.items()}


field = field_of(grid_of(64, 64, 10, 0.5))
warm_up(field, 2)
before, engine = compiled(), Engine(field, 2)
rig = preset("W+T")
tilt = lambda sensor: sensor.replace(rpy_deg=(3.0, -4.0, sensor.rpy_deg[2]))
near = lambda sensor: sensor.replace(range_m=(0.5, 8.0))
azimuths = tuple(0.2 * turn for turn in range(40))
close = lambda sensor: tilt(sensor.replace(azimuths_deg=azimuths) if sensor.kind == "lidar" else sensor)
for change in (tilt, near, close, lambda sensor: sensor):
    engine.evaluate(rig.model_copy(update={"sensors": tuple(change(sensor) for sensor in rig.sensors)}))
low = lambda sensor: tilt(sensor.replace(position=(*sensor.position[:2], 1.5)))
for change in (low, lambda sensor: low(sensor).replace(rpy_deg=sensor.rpy_deg)):
    sensors = tuple(change(sensor) for sensor in rig.sensors)
    for one in (engine, Engine(field, 1)):  # few threads, as beside other programs
        one.evaluate(rig.model_copy(update={"sensors": sensors}), MetricSettings(body="blocks"))
first = rig.sensors[0]
for x in (0.0, 0.1):
    moved = first.replace(position=(x, *first.position[1:]))
    engine.evaluate(rig.with_sensor(first.name, moved))
print([name for name, code in compiled().items() if code != before[name]])
print([name for name, code in compiled().items() if "Literal" in str(list(code))])
"""


def test_after_the_warm_up_no_kernel_is_left_to_compile() -> None:
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, encoding="utf-8", timeout=TIMEOUT_S
    )
    assert done.returncode == 0, done.stderr
    to_compile, for_one_number = done.stdout.split("\n", 1)
    assert to_compile == "[]"
    assert for_one_number.strip() == "[]"


OF_ONE_RIG = """
from riglens.core.engine.warm_up import warm_up
from riglens.core.kernels.beams import beam_cones
from riglens.core.kernels.cameras import frustum
from riglens.core.kernels.fans import fan
from riglens.core.kernels.rays import cast
from riglens.core.rig.presets import preset
from tests.core.builders import field_of, grid_of

warm_up(field_of(grid_of(40, 40, 10, 0.5)), 2, preset("W+T"))
others = (cast.mark_rays, frustum.mark_frustum, beam_cones.mark_sheets)
print(len(fan.mark_fan.signatures), sum(len(kernel.signatures) for kernel in others))
"""


def test_the_warm_up_for_one_rig_compiles_what_it_needs_and_no_other_way() -> None:
    done = subprocess.run(
        [sys.executable, "-c", OF_ONE_RIG], capture_output=True, encoding="utf-8", timeout=TIMEOUT_S
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["1", "0"]
