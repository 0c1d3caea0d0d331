"""Random edits of rigs made of the library's models: every answer has the bits of an evaluation from scratch.

`python -m tests.core.campaigns edits` makes as many as one likes. A chain of edits follows from its number alone.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.metric.scores import Body, Method, MetricSettings, Reading
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.grid import VoxelGrid
from tests.core.builders import evaluate, random_sensor
from tests.core.poses import any_model, any_pose
from tests.core.rooms import ROOMS, field_at

if TYPE_CHECKING:
    from numpy.random import Generator


T = TypeVar("T")
METHODS: tuple[Method, ...] = ("exact", "bresenham")
READINGS: tuple[Reading, ...] = ("covered", "residual", "hits")
BODIES: tuple[Body, ...] = ("ignored", "ignored", "blocks")


class Editor:
    """Makes one random edit after the other and remembers the rigs before, as undo does."""

    def __init__(self, rng: Generator, grid: VoxelGrid) -> None:
        self.rng, self.grid = rng, grid
        self.past: list[tuple[Rig, MetricSettings]] = []
        self.rig, self.settings = Rig(), MetricSettings()
        self.made = 0

    def step(self) -> None:
        """One edit; the kind of edit is drawn at random."""
        self.past.append((self.rig, self.settings))
        edits = [self.add, self.add, self.remove, self.switch, self.edit, self.edit, self.rename, self.undo]
        edits += [self.duplicate, self.reorder, self.choose_method, self.choose_reading]
        edits[int(self.rng.integers(len(edits)))]()

    def sensor(self) -> Sensor:
        """A new sensor."""
        return random_sensor(self.grid, self.rng)

    def place(self) -> dict[str, object]:
        """What changes when a sensor is moved."""
        return {"position": tuple(map(float, self.rng.uniform(-3.0, 3.0, 3)))}

    def _put(self, *sensors: object) -> None:
        self.rig = self.rig.replace(sensors=tuple(sensors))

    def _one_of(self, choices: tuple[T, ...]) -> T:
        return choices[int(self.rng.integers(len(choices)))]

    def _some(self) -> int:
        return int(self.rng.integers(len(self.rig.sensors)))

    def add(self) -> None:
        self.made += 1
        self._put(*self.rig.sensors, self.sensor().replace(name=f"new{self.made}"))

    def duplicate(self) -> None:
        if self.rig.sensors:
            self.made += 1
            self._put(*self.rig.sensors, self.rig.sensors[self._some()].replace(name=f"copy{self.made}"))

    def remove(self) -> None:
        if self.rig.sensors:
            gone = self._some()
            self._put(*(s for i, s in enumerate(self.rig.sensors) if i != gone))

    def _change(self, **changes: object) -> None:
        if self.rig.sensors:
            chosen = self._some()
            self._put(*(s.replace(**changes) if i == chosen else s for i, s in enumerate(self.rig.sensors)))

    def switch(self) -> None:
        self._change(enabled=bool(self.rng.random() < 0.5))

    def edit(self) -> None:
        self._change(**self.place())

    def rename(self) -> None:
        self.made += 1
        self._change(name=f"name{self.made}", model="another")

    def reorder(self) -> None:
        self._put(*(self.rig.sensors[i] for i in self.rng.permutation(len(self.rig.sensors))))

    def choose_method(self) -> None:
        self.settings = replace(self.settings, method=self._one_of(METHODS))

    def choose_reading(self) -> None:
        weight = float(self.rng.uniform(0.0, 1.0))
        self.settings = replace(self.settings, reading=self._one_of(READINGS), camera_weight=weight)

    def undo(self) -> None:
        self.rig, self.settings = self.past[int(self.rng.integers(len(self.past)))]


class LibraryEditor(Editor):
    """Edits rigs of at most MOST sensors, all of them models of the library; at times the car's body stops rays."""

    MOST, MOST_RAYS = 6, 8_000

    def choose_method(self) -> None:
        super().choose_method()
        self.settings = replace(self.settings, body=self._one_of(BODIES))

    def sensor(self) -> Sensor:
        return any_model(self.rng, self.grid, self.MOST_RAYS)

    def place(self) -> dict[str, object]:
        pose = any_pose(self.rng, self.grid)
        return {"position": pose.position_m, "rpy_deg": pose.rpy_deg}

    def add(self) -> None:
        self.remove() if len(self.rig.sensors) >= self.MOST else super().add()

    def duplicate(self) -> None:
        self.remove() if len(self.rig.sensors) >= self.MOST else super().duplicate()


def differs(found: Evaluation, expected: Evaluation) -> bool:
    """Whether two evaluations differ in any bit."""
    return found.scores != expected.scores or not (
        np.array_equal(found.seen["camera"], expected.seen["camera"])
        and np.array_equal(found.seen["lidar"], expected.seen["lidar"])
    )


def try_edits(seed: int, count: int) -> str:
    """Make a chain of edits with one engine; return what is wrong, nothing where all answers have the right bits."""
    rng = np.random.default_rng(seed)
    voxel_m, roi_m = ROOMS[rng.integers(len(ROOMS))]
    field = field_at(voxel_m, roi_m, float(rng.choice([1.0, 0.3])))
    editor, engine = LibraryEditor(rng, field.grid), Engine(field, 1)
    for made in range(1, count + 1):
        editor.step()
        held = engine.evaluate(editor.rig, editor.settings)
        if differs(held, evaluate(field, editor.rig, editor.settings)):
            return f"chain {seed}: edit {made} differs from an evaluation from scratch"
    return ""
