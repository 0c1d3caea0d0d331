"""Random edits of a rig: the engine that carries its state along against an evaluation from scratch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import METHODS, READINGS, MetricSettings
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES, DataReport, Progress
from riglens.core.scene.columns import VoxelIndex, pack, unpack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.study.stability_cases import camera, spinning
from riglens.core.study.stability_methods import NOT_APPLICABLE, MethodRow, Outcome

Counts = NDArray[np.int64]
GRID = VoxelGrid(0.5, (5.0, 4.5, 3.0))
MOST_SENSORS = 6
REMEMBERED = 40
FRAMES = 1000


def random_counts(grid: VoxelGrid, rng: np.random.Generator, share: float = 0.3) -> Counts:
    """Random counts out of FRAMES, (nx, ny, nz, 3), not 0 in a share of the voxels per class."""
    shape = (*grid.shape, len(CLASSES))
    drawn: Counts = rng.integers(1, FRAMES, shape) * (rng.random(shape) < share)
    return drawn


def field_of(grid: VoxelGrid, counts: Counts) -> EntropyField:
    """The entropies of counts (nx, ny, nz, 3) out of FRAMES."""
    occupied: NDArray[np.bool_] = np.any(counts, axis=-1)
    index = VoxelIndex.of(grid, pack(grid, occupied))
    i, j, k = index.ijk().T
    data = DataReport("random", FRAMES, dict.fromkeys(CLASSES, 1))
    return EntropyField.from_pog(Pog(grid, data, index, counts[i, j, k].astype(np.uint16)))


class Editor:
    """Makes one random edit after another; undo returns to an earlier rig."""

    def __init__(self, grid: VoxelGrid, rng: np.random.Generator) -> None:
        self.rig, self.settings = Rig(), MetricSettings()
        self._grid, self._rng = grid, rng
        self._past: list[tuple[Rig, MetricSettings]] = []
        self._made = 0
        self._edits = [self._add, self._remove, self._switch, self._move, self._move, self._move]
        self._edits += [self._copy, self._reorder, self._choose, self._undo]

    def step(self) -> None:
        """One edit; which one is drawn at random."""
        self._past = [*self._past[-REMEMBERED:], (self.rig, self.settings)]
        self._edits[int(self._rng.integers(len(self._edits)))]()

    def _put(self, sensors: list[Sensor]) -> None:
        self.rig = self.rig.replace(sensors=tuple(sensors))

    def _pick(self) -> int:
        return int(self._rng.integers(len(self.rig.sensors)))

    def _name(self) -> str:
        self._made += 1
        return f"sensor {self._made}"

    def _place(self) -> tuple[float, float, float]:
        x, y, z = self._rng.uniform(-0.6, 0.6, 3) * self._grid.roi_m
        return float(x), float(y), float(z + self._grid.roi_m[2] / 2)

    def _add(self) -> None:
        if len(self.rig.sensors) < MOST_SENSORS:
            roll, pitch, yaw = self._rng.uniform(-30.0, 30.0, 3) * self._rng.integers(0, 2, 3)
            pose = self._place(), (float(roll), float(pitch), float(yaw))
            lidar = self._rng.random() < 0.5
            new = spinning(*pose, beams=3, count=10) if lidar else camera(*pose, (6, 5))
            self._put([*self.rig.sensors, new.replace(name=self._name())])

    def _remove(self) -> None:
        if self.rig.sensors:
            gone = self._pick()
            self._put([sensor for n, sensor in enumerate(self.rig.sensors) if n != gone])

    def _change(self, **changes: object) -> None:
        if self.rig.sensors:
            chosen = self._pick()
            self._put([s.replace(**changes) if n == chosen else s for n, s in enumerate(self.rig.sensors)])

    def _switch(self) -> None:
        self._change(enabled=bool(self._rng.random() < 0.5))

    def _move(self) -> None:
        self._change(position=self._place())

    def _copy(self) -> None:
        if 0 < len(self.rig.sensors) < MOST_SENSORS:
            twin = self.rig.sensors[self._pick()].replace(name=self._name())
            self._put([*self.rig.sensors, twin])

    def _reorder(self) -> None:
        self._put([self.rig.sensors[n] for n in self._rng.permutation(len(self.rig.sensors))])

    def _choose(self) -> None:
        method = METHODS[int(self._rng.integers(len(METHODS)))]
        reading = READINGS[int(self._rng.integers(len(READINGS)))]
        self.settings = MetricSettings(method, reading, float(self._rng.uniform(0.0, 1.0)))

    def _undo(self) -> None:
        self.rig, self.settings = self._past[int(self._rng.integers(len(self._past)))]


class RunningSum:
    """Seen entropy the simple way: doubles added when voxels come into view and subtracted when they leave it."""

    def __init__(self, counts: Counts) -> None:
        p = counts[..., 0] / FRAMES
        inner = np.where(p > 0.0, p, 0.5)
        self._h = np.where(p > 0.0, -inner * np.log(inner) - (1.0 - inner) * np.log1p(-inner), 0.0)
        self._seen = np.zeros(self._h.shape, np.bool_)
        self.sum_nat = 0.0

    def follow(self, seen: NDArray[np.bool_]) -> None:
        """Update the sum to the voxels seen now."""
        self.sum_nat += float(self._h[seen & ~self._seen].sum()) - float(self._h[self._seen & ~seen].sum())
        self._seen = seen

    def from_scratch_nat(self) -> float:
        """The same sum over the voxels seen, in one go."""
        return float(self._h[self._seen].sum())


def _same(one: Evaluation, other: Evaluation) -> bool:
    seen = np.array_equal(one.seen["camera"], other.seen["camera"]) and np.array_equal(
        one.seen["lidar"], other.seen["lidar"]
    )
    return seen and one.scores == other.scores


def random_edits(edits: int, progress: Progress | None = None) -> MethodRow:
    """Make random edits; after each one the engine's result is compared with that of a new engine.

    On one thread: the grid is tiny, and that threads change nothing is a case of its own.
    """
    rng = np.random.default_rng(edits)
    counts = random_counts(GRID, rng)
    field, editor = field_of(GRID, counts), Editor(GRID, rng)
    engine, running = Engine(field, 1), RunningSum(counts)
    different = drifted = 0
    for edit in range(edits):
        editor.step()
        found = engine.evaluate(editor.rig, editor.settings)
        fresh = Engine(field, 1).evaluate(editor.rig, editor.settings)
        different += not _same(found, fresh)
        running.follow(unpack(GRID, fresh.seen_by_any()))
        drifted += running.sum_nat != running.from_scratch_nat()
        if progress is not None:
            progress((edit + 1) / edits)
    fast = Outcome("fails", f"{different:,} differ") if different else Outcome("ok", "bit-identical")
    plain = Outcome("fails", f"{drifted:,} differ") if drifted else Outcome("ok", "identical")
    return MethodRow(
        f"{edits:,} random edits",
        "add, remove, switch, move, copy, reorder, undo: what is carried along must not drift "
        "(the simple way: a running sum of doubles)",
        "from scratch",
        {"fast": fast, "plain": plain, "bresenham": NOT_APPLICABLE},
    )
