"""Random edits of a rig: the incremental engine against an evaluation from scratch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.metric.scores import METHODS, READINGS, MetricSettings
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import Progress
from riglens.core.scene.columns import unpack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.study.stability_cases import camera, ray_cases, spinning
from riglens.core.study.stability_methods import (
    CHECKS,
    FRAMES,
    MethodRow,
    Outcome,
    field_of,
    judged,
    random_counts,
    row,
)

EDITS, QUICK_EDITS = 1000, 100
GRID = VoxelGrid(0.5, (5.0, 4.5, 3.0))
MOST_SENSORS = 6
REMEMBERED = 40
_KINDS = ("add", "remove", "switch", "move", "move", "move", "copy", "reorder", "choose", "undo")


def method_rows(
    quick: bool = False, edits: int = EDITS, threads: int | None = None, progress: Progress | None = None
) -> tuple[MethodRow, ...]:
    """Run every case of methods: rays, the whole evaluation, random edits; `progress` gets the fraction done."""
    cases = [*ray_cases(quick)]
    steps = len(cases) + len(CHECKS) + 1

    def part(done: int) -> Progress:
        return lambda fraction: None if progress is None else progress((done + fraction) / steps)

    rows = [judged(case, threads, part(number)) for number, case in enumerate(cases)]
    for number, check in enumerate(CHECKS, len(cases) + 1):
        rows.append(check(threads))
        part(number)(0.0)
    return (*rows, random_edits(edits, part(steps - 1)))


class Editor:
    """Source of random edits, one after another; undo returns to an earlier rig."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rig, self.settings = Rig(), MetricSettings()
        self._rng, self._made = rng, 0
        self._past: list[tuple[Rig, MetricSettings]] = []

    def step(self) -> None:
        """Make one edit, drawn at random."""
        self._past = [*self._past[-REMEMBERED:], (self.rig, self.settings)]
        sensors, rng = list(self.rig.sensors), self._rng
        kind = _KINDS[int(rng.integers(len(_KINDS)))]
        if kind == "add" and len(sensors) < MOST_SENSORS:
            roll, pitch, yaw = rng.uniform(-30.0, 30.0, 3) * rng.integers(0, 2, 3)
            pose = self._place(), (float(roll), float(pitch), float(yaw))
            is_lidar = rng.random() < 0.5
            new = spinning(*pose, beams=3, count=10) if is_lidar else camera(*pose, (6, 5))
            sensors.append(new.replace(name=self._name()))
        elif kind == "remove" and sensors:
            del sensors[self._pick()]
        elif kind in ("switch", "move"):
            changes = (
                {"enabled": bool(rng.random() < 0.5)} if kind == "switch" else {"position": self._place()}
            )
            if sensors:
                chosen = self._pick()
                sensors[chosen] = sensors[chosen].replace(**changes)
        elif kind == "copy" and 0 < len(sensors) < MOST_SENSORS:
            sensors.append(sensors[self._pick()].replace(name=self._name()))
        elif kind == "reorder":
            sensors = [sensors[n] for n in rng.permutation(len(sensors))]
        elif kind == "choose":
            method = METHODS[int(rng.integers(len(METHODS)))]
            reading = READINGS[int(rng.integers(len(READINGS)))]
            self.settings = MetricSettings(method, reading, float(rng.uniform(0.0, 1.0)))
        elif kind == "undo":
            self.rig, self.settings = self._past[int(rng.integers(len(self._past)))]
            return
        self.rig = self.rig.replace(sensors=tuple(sensors))

    def _pick(self) -> int:
        return int(self._rng.integers(len(self.rig.sensors)))

    def _name(self) -> str:
        self._made += 1
        return f"sensor {self._made}"

    def _place(self) -> tuple[float, float, float]:
        x, y, z = self._rng.uniform(-0.6, 0.6, 3) * GRID.roi_m
        return float(x), float(y), float(z + GRID.roi_m[2] / 2)


class RunningSum:
    """Seen entropy the simple way: doubles added when voxels come into view and subtracted when they leave it."""

    def __init__(self, counts: NDArray[np.int64]) -> None:
        p = counts[..., 0] / FRAMES
        inner = np.where(p > 0.0, p, 0.5)
        self._h = np.where(p > 0.0, -inner * np.log(inner) - (1.0 - inner) * np.log1p(-inner), 0.0)
        self._seen = np.zeros(self._h.shape, np.bool_)
        self._sum_nat = 0.0

    def drifts(self, seen: NDArray[np.bool_]) -> bool:
        """Update the sum to the voxels seen now; return whether it differs from the same sum in one go."""
        self._sum_nat += float(self._h[seen & ~self._seen].sum()) - float(self._h[self._seen & ~seen].sum())
        self._seen = seen
        return self._sum_nat != float(self._h[seen].sum())


def random_edits(edits: int, progress: Progress | None = None) -> MethodRow:
    """Make random edits; after each one the engine's result is compared with that of a new engine.

    On one thread: the grid is tiny, and that threads change nothing is a case of its own.
    """
    rng = np.random.default_rng(edits)
    counts = random_counts(GRID, rng)
    field, editor = field_of(GRID, counts), Editor(rng)
    engine, running = Engine(field, 1), RunningSum(counts)
    different = drifted = 0
    for edit in range(edits):
        editor.step()
        found = engine.evaluate(editor.rig, editor.settings)
        fresh = Engine(field, 1).evaluate(editor.rig, editor.settings)
        same_sets = (np.array_equal(found.seen[kind], fresh.seen[kind]) for kind in ("camera", "lidar"))
        different += found.scores != fresh.scores or not all(same_sets)
        drifted += running.drifts(unpack(GRID, fresh.seen_by_any()))
        if progress is not None:
            progress((edit + 1) / edits)
    return row(
        f"{edits:,} random edits",
        "add, remove, switch, move, copy, reorder, undo: the state must not drift "
        "(plain method: a running sum of doubles)",
        "from scratch",
        Outcome.of(different == 0, "bit-identical", f"{different:,} differ"),
        plain=Outcome.of(drifted == 0, "identical", f"{drifted:,} differ"),
    )
