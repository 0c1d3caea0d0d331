"""Kernels of the engine, compiled or loaded from disk before they are needed."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import singledispatch
from typing import NamedTuple

import numpy as np

from riglens.core.engine.blocking import blocked
from riglens.core.engine.caster import Caster
from riglens.core.engine.engine import Engine
from riglens.core.engine.fans import has_few, make_fan, make_profile
from riglens.core.kernels.fans.fan import mark_fan, work_by_row
from riglens.core.kernels.fans.leftover_rays import mark_alone
from riglens.core.kernels.fans.planes import Fan
from riglens.core.kernels.fans.profile import Profile
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.runtime.jit import FOLDER, use_threads
from riglens.core.kernels.voxels import update_coverage
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import BrownConrady, Camera, Lidar, LinearAngles, Rig, Sensor, Vehicle
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.scene.columns import VoxelIndex, pack, words_per_column
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensing.rays import is_listed
from riglens.core.sensors.registry import kind_names
from riglens.core.vehicle.solid import solid_of

WARM_UP = Rig(
    sensors=(
        Lidar(name="lidar", position=(0.0, 0.0, 2.0), elevations_deg=(0.0,), azimuths_deg=(0.0,)),
        Lidar(
            name="close",
            position=(0.0, 0.0, 2.0),
            rpy_deg=(0.0, 5.0, 0.0),
            elevations_deg=(0.0,),
            azimuths_deg=LinearAngles(from_=0.0, to=60.0, count=1000),
        ),
        Camera(name="camera", position=(0.0, 0.0, 2.0), hfov_deg=90.0, cast=(1, 1)),
        Camera(
            name="tilted", position=(0.0, 0.0, 2.0), rpy_deg=(0.0, 5.0, 45.0), hfov_deg=90.0, cast=(49, 48)
        ),
    )
)
"""Rig of small sensors: upright ones, a tilted LiDAR whose rays are close, and a tilted camera dense enough for voxel
walking and too sparse for it alone, whose middle column runs through edges of voxels: there only the exact walk can
tell."""
BENT = Camera(
    name="bent", position=(0.0, 0.0, 2.0), image=(64, 64), cast=(64, 64), fx=64.0, fy=64.0, cx=32.0, cy=32.0,
    distortion=BrownConrady(k1=-0.1),
)  # fmt: skip
"""A lens with distortion: not every rig has one, so only the process that compiles every kernel does this one too."""
ON_THE_CAR = Rig(
    sensors=(
        Lidar(name="lidar", position=(0.0, 0.0, 1.7), elevations_deg=(-60.0, 0.0), azimuths_deg=(0.0,)),
        Camera(
            name="camera", position=(0.0, 0.0, 1.7), rpy_deg=(0.0, 40.0, 0.0), hfov_deg=90.0, cast=(64, 64)
        ),
    )
)
"""Sensors so close to the roof of the usual car that it stops some of their rays."""


def warm_up(
    field: EntropyField,
    threads: int | None = None,
    rig: Rig | None = None,
    settings: MetricSettings | None = None,
    vehicle: Vehicle = ON_THE_CAR.vehicle,
) -> None:
    """Compile the kernels that a rig needs, without one those that most rigs need, on a car that is made for them, or
    load them from disk, so that no answer's time includes it."""
    engine = Engine(field, threads, for_edits=False)
    if rig is None or needs_fans(rig):
        compile_fans(field)
    if rig is not None:
        engine.evaluate(rig, settings or MetricSettings(), with_seen=False)
        return
    engine.evaluate(WARM_UP, with_seen=False)
    on_it = ON_THE_CAR.model_copy(update={"vehicle": vehicle})
    for one in (engine, Engine(field, 1, for_edits=False)):  # edits beside other programs take one thread
        one.evaluate(on_it, MetricSettings(body="blocks"), with_seen=False)
    _compile_edits(field)


def _compile_edits(field: EntropyField) -> None:
    """Compile what an edit needs besides the first score: the voxels that the staying sensors leave free."""
    words, rows = field.index.words, field.grid.shape[0]
    region = update_coverage.Region(0, rows, 0, words.size // rows, words.size // rows)
    none, slot = np.zeros(0, np.int64), np.zeros(1, np.int64)
    stack, counts = np.zeros((1, words.size), np.uint64), np.zeros((1, words.size), np.uint64)
    update_coverage.count_others(
        stack, update_coverage.Slots(slot, none), region, words, 1, counts, words.copy()
    )


def needs_fans(rig: Rig) -> bool:
    """Return whether some sensor of a rig is cast by vertical planes."""
    return any(
        sensor.enabled and sensor.rpy_deg[:2] == (0.0, 0.0) and _has_planes(sensor) for sensor in rig.sensors
    )


@singledispatch
def _has_planes(sensor: Sensor) -> bool:
    """Return whether an upright sensor is cast by vertical planes, those of each azimuth offset on their own if it has
    few."""
    return not is_listed(sensor)


@_has_planes.register
def _have_planes(lidar: Lidar) -> bool:
    offsets = lidar.azimuth_offsets_deg
    return lidar.rays is None and not lidar.blocked and (offsets is None or has_few(offsets))


def compile_fans(field: EntropyField) -> None:
    """Compile the walk over the planes of a fan, and over single rays: more than half of what the usual rig needs."""
    fan, rays = _least_fan(field)
    depth = words_per_column(field.grid)
    nothing = Profile(np.array([np.inf]), np.zeros(0, np.int32), np.zeros((1, depth), np.uint64), 0)
    marks = np.zeros(field.index.words.size, np.uint64)
    none, left = np.zeros(1, np.int64), np.empty((1, 1, 6), np.int32)
    mark_fan(fan, rays, nothing, None, 0, np.zeros((1, 2), np.int64), none, left, none.copy(), marks)
    mark_alone(rays, left, none, marks)


def compile_sums(field: EntropyField) -> None:
    """Compile what else a rig of upright sensors needs: rays by distance, and the sums of a first sensor."""
    fan, rays = _least_fan(field)
    profile = make_profile(fan, rays)
    assert profile is not None
    work_by_row(fan, rays, profile)
    words, rows = field.index.words.size, field.grid.shape[0]
    stack, union = np.zeros((1, words), np.uint64), np.zeros((len(kind_names()), words), np.uint64)
    slots = update_coverage.Slots(np.zeros(1, np.int64), np.zeros(0, np.int64))
    region = update_coverage.Region(0, rows, 0, words // rows, words // rows)
    kinds = np.zeros(1, np.int64)
    update_coverage.settle(stack, union, field.index.words, slots, kinds, region, field.entropies, 1)


def compile_cameras(field: EntropyField) -> None:
    """Compile what cameras that roll or pitch need, where the car's body stops rays too."""
    caster, camera = Caster(field, use_threads(None)), ON_THE_CAR.sensors[1]
    marks, barrier = (
        np.zeros(field.index.words.size, np.uint64),
        barrier_of(camera, solid_of(ON_THE_CAR.vehicle)),
    )
    caster.mark(camera.replace(cast=(256, 256)), "exact", caster.window(camera), marks)
    blocked(caster.rays(camera, "exact"), field, camera, "exact", barrier, caster.workers)


def compile_walk(field: EntropyField) -> None:
    """Compile what else a rig of tilted sensors needs: the walk along rays, close together or alone, and the sums."""
    engine = Engine(field, for_edits=False)
    for settings in (MetricSettings(), MetricSettings(method="bresenham")):  # which walks each ray
        engine.evaluate(Rig(sensors=WARM_UP.sensors[1:2]), settings, with_seen=False)


class Halves(NamedTuple):
    """Halves of what a rig's first score needs: `beside` is compiled by another process, `here` meanwhile."""

    beside: Callable[[EntropyField], None]
    here: Callable[[EntropyField], None]


HALVES = {"fans": Halves(compile_fans, compile_sums), "cameras": Halves(compile_cameras, compile_walk)}


def halves_of(rig: Rig) -> str | None:
    """Return the name of the halves to compile for a rig, or None if there is too little work to split."""
    if needs_fans(rig):
        return "fans"
    return "cameras" if rig.enabled_cameras() else None


def compile_beside(name: str) -> None:
    """Compile the half of another process to disk, and say that it is there."""
    HALVES[name].beside(tiny_field())
    FOLDER.write(mark_of(name), b"")


def is_compiled(name: str) -> bool:
    """Return whether a process has compiled its half for these sources before."""
    return FOLDER.read(mark_of(name)) is not None


def mark_of(name: str) -> str:
    """Return the name of the file that says so."""
    return f"half-{name}-{FOLDER.sources.digest}-{sys.implementation.cache_tag}"


def _least_fan(field: EntropyField) -> tuple[Fan, Cast]:
    """Return the fan of a LiDAR with one ray, and the ray."""
    rays = Caster(field).rays(WARM_UP.sensors[0], "exact")
    return make_fan(rays), rays


def tiny_field(voxel_m: float = 1.0) -> EntropyField:
    """Return a field wide enough for rays to drift apart; in half of its voxels a box stands in one of two frames."""
    grid = VoxelGrid(voxel_m, (60.0, 60.0, 4.0))
    occupied = np.ones(grid.shape, np.bool_)
    occupied[::2] = False
    index = VoxelIndex.of(grid, pack(grid, occupied))
    counts = np.ones((int(occupied.sum()), len(CLASSES)), np.uint16)
    return EntropyField.from_pog(
        Pog.of(grid, DataReport("tiny", 2, dict.fromkeys(CLASSES, 1)), index, counts)
    )
