"""One sensor of every class that the library has, upright and tilted, on one thread, against competent plain DDA."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from riglens.core.rig.model import Camera, Rig
from tests.bench.race import Goal, Race
from tests.bench.scenes import (
    Scenes,
    competent_edit,
    dense_rays,
    moves,
    require_same_answer,
    way_taken,
    with_model,
)

ROUNDS = 5
PAPER_CAST = (352, 128)


@dataclass(frozen=True)
class Kind:
    """A class of sensors, the model that stands for it, and the goals upright and tilted."""

    name: str
    model: str
    upright: float
    tilted: float


KINDS = (
    Kind("spinning, 16 beams", "velodyne-vlp-16", 3.0, 1.5),
    Kind("spinning, 32 beams", "hesai-xt32", 3.0, 1.8),
    Kind("spinning, 64 beams", "ouster-os1-64", 4.0, 2.5),
    Kind("spinning, 128 x 3600", "dense", 10.0, 4.0),
    Kind("offsets, 32 beams", "velodyne-vlp-32c", 1.8, 1.8),
    Kind("offsets, 64 beams", "hesai-pandar64", 4.0, 2.5),
    Kind("offsets, 128 beams", "velodyne-vls-128", 4.0, 4.0),
    Kind("offsets, 128 x 1024", "ouster-os1-128", 4.0, 4.0),
    Kind("every beam its offset", "hesai-pandar128e4x", 4.0, 4.0),
    Kind("solid-state sector", "robosense-m1", 4.0, 2.0),
    Kind("sector with offsets", "hesai-at128", 2.0, 2.0),
    Kind("hemisphere", "robosense-bpearl", 1.8, 1.8),
    Kind("distorted camera", "pandaset-wide", 2.0, 2.0),
    Kind("distorted camera, native", "pandaset-wide", 20.0, 20.0),
)


def rig_with(kind: Kind, pose: str) -> tuple[Rig, str]:
    """W+T with the sensor of a class, and its name."""
    rig, name = with_model("ouster-os1-128" if kind.model == "dense" else kind.model, pose)
    sensor = rig.sensor(name)
    if kind.model == "dense":
        sensor = dense_rays(sensor.replace(azimuth_offsets_deg=None))
    if isinstance(sensor, Camera):
        sensor = sensor.replace(cast=sensor.image if kind.name.endswith("native") else PAPER_CAST)
    return rig.with_sensor(name, sensor), name


BUDGETS_MS = {"livox-avia-pattern": 30.0, "generic-corner-radar": 5.0, "generic-ultrasonic": 5.0}
"""Times that a step of a drag may take: a frame less what drawing takes."""


@pytest.mark.parametrize("model", BUDGETS_MS)
def test_a_drag_keeps_its_budget(race: Race, scenes: Scenes, model: str) -> None:
    scene = scenes.at(0.10)
    rig, name = with_model(model, "upright")
    require_same_answer(scene, rig.sensor(name))
    engine = scene.engine(1)
    engine.evaluate(rig)
    work = f"{model} dragged, one thread, {scene.edge}, yardstick: its budget"
    race.within(
        Goal("sensors", work, 1.0, "lower"),
        moves(scene, rig, [name]),
        lambda m: engine.evaluate(m.rig, with_seen=False),
        BUDGETS_MS[model],
    )


@pytest.mark.parametrize("pose", ["upright", "tilted"])
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
@pytest.mark.parametrize("voxel_m", [0.10, 0.05])
def test_kind(race: Race, scenes: Scenes, voxel_m: float, kind: Kind, pose: str) -> None:
    scene = scenes.at(voxel_m)
    rig, name = rig_with(kind, pose)
    require_same_answer(scene, rig.sensor(name))
    engine = scene.engine(1)
    engine.evaluate(rig)
    work = f"{kind.name} ({kind.model}), {pose}, by {way_taken(scene, rig.sensor(name))}, one thread, {scene.edge}"
    race.run(
        Goal("sensors", work, kind.tilted if pose == "tilted" else kind.upright),
        moves(scene, rig, [name]),
        lambda m: engine.evaluate(m.rig, with_seen=False),
        lambda m: competent_edit(scene, m),
        rounds=ROUNDS,
    )
