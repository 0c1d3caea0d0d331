"""Methods compared in the accuracy study: each scores one rig on one grid, and is ready to be timed.

A case prepares (not timed), runs (timed: from the rig to S-MS of all classes) and reports its coverage.
Everything that belongs to the scene alone - POG, entropies, dense grids, lists of voxels - is ready before,
and so are the rays of plain DDA; the engine makes its rays within its time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.caster import RAYS_PER_CHUNK, Caster
from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.kernels.rays.cast import add_marks, mark_rays
from riglens.core.kernels.runtime import jit
from riglens.core.kernels.voxels import bits, update_coverage
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings, s_ms
from riglens.core.metric.scoring import score
from riglens.core.rig.model import Camera, Lidar, Rig, Sensor
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.scene.columns import Words
from riglens.core.sensors.registry import kind_names
from riglens.core.study.simple_methods import FLAGS, KINDS, PlainDda, VoxelTests, grid_rays

MOVED_M = 0.1
SLOW_MS = 3000.0
LatticeName = Literal["own", "1/2", "1/4", "1/8", "all pixels"]
_STEPS: dict[LatticeName, tuple[int, tuple[int, int]]] = {
    "1/2": (2, (2, 1)),
    "1/4": (4, (2, 2)),
    "1/8": (8, (4, 2)),
}
"""Step between the azimuths, image columns and image rows that are kept."""
Seen = NDArray[np.uint8]


@dataclass(frozen=True)
class Answer:
    """S-MS in nat per class; bit 1: seen by cameras, bit 2: by LiDARs, (n,) over the informative voxels."""

    s_ms: tuple[float, ...]
    seen: Seen


class Case(Protocol):
    """One way of scoring the rig."""

    def prepare(self) -> None:
        """Do what must not count towards the time; called before every run."""

    def run(self) -> None:
        """Score the rig."""

    def answer(self) -> Answer:
        """Return what the last run found."""


class EngineCase:
    """The engine, fresh, or holding the rig as it was before an edit."""

    def __init__(
        self,
        field: EntropyField,
        rig: Rig,
        settings: MetricSettings,
        threads: int | None,
        before: Rig | None = None,
    ) -> None:
        self._field, self._rig, self._settings, self._threads = field, rig, settings, threads
        self._before = before
        self._evaluation: Evaluation | None = None

    def prepare(self) -> None:
        """A fresh engine, which knows the rig before the edit if there is one."""
        self._engine = Engine(self._field, self._threads)
        if self._before is not None:
            self._engine.evaluate(self._before, self._settings)

    def run(self) -> None:
        """Score the rig."""
        self._evaluation = self._engine.evaluate(self._rig, self._settings)

    def answer(self) -> Answer:
        """Return what the last run found."""
        assert self._evaluation is not None
        found = self._evaluation
        seen = np.zeros(self._field.index.count, np.uint8)
        for kind, flag in FLAGS.items():
            seen[_ids(self._field, found.seen[kind])] |= np.uint8(flag)
        return Answer(tuple(found.scores.classes[cls].s_ms for cls in CLASSES), seen)


class PlainCase:
    """Plain DDA on one thread, in double or in single precision; with a step, points on the rays instead.

    Cases that are never run at once may share the dense grids of one `dda`.
    """

    def __init__(
        self,
        field: EntropyField,
        rig: Rig,
        camera_weight: float,
        real: type[np.floating[Any]],
        dda: PlainDda | None = None,
        step_voxels: float | None = None,
    ) -> None:
        self._dda = dda or PlainDda(field)
        self._field, self._camera_weight, self._step_voxels = field, camera_weight, step_voxels
        self._rays = [grid_rays(sensor, field.grid, real) for sensor in rig.sensors if sensor.enabled]

    def prepare(self) -> None:
        """Do nothing: clearing the dense grid counts towards the time."""

    def run(self) -> None:
        """Clear, cast all rays, sum."""
        self._dda.clear()
        for rays in self._rays:
            if self._step_voxels is None:
                self._dda.cast(rays)
            else:
                self._dda.sample(rays, self._step_voxels)
        self._sums = self._dda.sums()

    def answer(self) -> Answer:
        """Return what the last run found."""
        ix, iy, iz = self._field.index.ijk().T
        by_camera, by_lidar = (seen[ix, iy, iz] for seen in self._dda.seen)
        flags = by_camera * np.uint8(FLAGS["camera"]) | by_lidar * np.uint8(FLAGS["lidar"])
        return Answer(_s_ms(self._sums, self._camera_weight), flags)


class WalkCase:
    """Every ray of one sensor by the exact walk, ray by ray, and the engine's own sum: the slow way to its answer."""

    def __init__(self, field: EntropyField, sensor: Sensor, settings: MetricSettings, threads: int) -> None:
        self._field, self._sensor, self._settings = field, sensor, settings
        self._caster = Caster(field, threads)

    def prepare(self) -> None:
        """Memory for the sets of voxels."""
        words = self._field.index.words.size
        self._stack, self._union = (
            np.zeros((1, words), np.uint64),
            np.zeros((len(kind_names()), words), np.uint64),
        )
        self._spare = np.zeros((self._caster.workers - 1, words), np.uint64)

    def run(self) -> None:
        """Walk all rays, then settle one set against nothing."""
        jit.use_threads(self._caster.workers)
        rays, marks = self._caster.rays(self._sensor, "exact"), self._stack[0]
        count = len(rays.rows) * len(rays.planes)
        for start in range(0, count, RAYS_PER_CHUNK):
            end = min(start + RAYS_PER_CHUNK, count)
            left = np.ones(end - start, np.bool_)
            mark_rays(rays, start, end, marks, self._spare, left)
            for word, bit in self._caster.walk_irregular(rays, start + np.flatnonzero(left)):
                marks[word] |= bit
        add_marks(self._spare, marks, self._caster.workers)
        self._sums_q = self._settled()

    def _settled(self) -> NDArray[np.int64]:
        """Return sums int64 (kinds + 1, 4) over the marked voxels."""
        nx, words = self._field.grid.shape[0], self._field.index.words.size
        region = update_coverage.Region(0, nx, 0, words // nx, words // nx)
        slots, keep = (
            update_coverage.Slots(np.zeros(1, np.int64), np.zeros(0, np.int64)),
            self._field.index.words,
        )
        kind, rows = kind_names().index(self._sensor.kind), len(kind_names()) + 1
        sums_q = np.zeros((rows, update_coverage.COLUMNS), np.int64)
        change = update_coverage.settle(
            self._stack,
            self._union,
            keep,
            slots,
            np.array([kind]),
            region,
            self._field.entropies,
            self._caster.workers,
        )
        sums_q[kind], sums_q[-1] = change
        return sums_q

    def answer(self) -> Answer:
        """Return what the last run found."""
        scores = score(self._field, self._sums_q, self._settings)
        seen = np.zeros(self._field.index.count, np.uint8)
        kind = self._sensor.kind
        seen[_ids(self._field, self._union[kind_names().index(kind)])] = FLAGS[kind]
        return Answer(tuple(scores.classes[cls].s_ms for cls in CLASSES), seen)


class VoxelCase:
    """One of the two tests voxel by voxel."""

    def __init__(
        self, tests: VoxelTests, rig: Rig, camera_weight: float, test: Literal["rectangles", "centres"]
    ) -> None:
        self._tests, self._rig, self._camera_weight = tests, rig, camera_weight
        self._cover = tests.bounding_rectangles if test == "rectangles" else tests.centres_in_view

    def prepare(self) -> None:
        """Nothing to do."""

    def run(self) -> None:
        """Test all voxels, sum."""
        self._seen = self._cover(self._rig)
        self._sums = self._tests.sums(self._seen)

    def answer(self) -> Answer:
        """Return what the last run found."""
        return Answer(_s_ms(self._sums, self._camera_weight), self._seen)


def timed(
    cases: Sequence[Case], repetitions: int, progress: Progress | None = None
) -> tuple[list[Answer], list[list[float]]]:
    """Answers of a warm-up round, then the times in ms of alternating repetitions; who takes longer than SLOW_MS runs
    once."""
    answers: list[Answer] = []
    times: list[list[float]] = [[] for _ in cases]
    for repetition in range(repetitions + 1):
        for number, case in enumerate(cases):
            if repetition > 1 and times[number][0] > SLOW_MS:
                continue
            case.prepare()
            started = time.perf_counter()
            case.run()
            elapsed_ms = (time.perf_counter() - started) * 1e3
            if repetition == 0:
                answers.append(case.answer())
            else:
                times[number].append(elapsed_ms)
            if progress is not None:
                progress((repetition * len(cases) + number + 1) / ((repetitions + 1) * len(cases)))
    return answers, times


def _s_ms(sums: NDArray[np.float64], camera_weight: float) -> tuple[float, ...]:
    return tuple(
        s_ms({kind: -float(sums[row, c]) for row, kind in enumerate(KINDS)}, camera_weight)
        for c in range(len(CLASSES))
    )


def _ids(field: EntropyField, words: Words) -> NDArray[np.int64]:
    ids = np.empty(bits.total_bits(words), np.int64)
    bits.gather_ids(field.index.words, field.index.first, words, ids)
    return ids


def moved(rig: Rig, sensor: Sensor) -> Rig:
    """The rig with one sensor 0.1 m further to the front and left, where an edit may have found it."""
    x, y, z = sensor.position
    elsewhere = sensor.model_copy(update={"position": (x + MOVED_M, y + MOVED_M, z)})
    return rig.with_sensor(sensor.name, elsewhere)


def with_lattice(rig: Rig, name: LatticeName) -> Rig:
    """Return the rig with every second, fourth or eighth of its rays, or with one ray per native pixel.

    Thinner lattices pick rays of the full one where its size can be divided; else the camera's is built again.
    """
    if name == "own":
        return rig
    if name == "all pixels":
        return _changed(rig, lambda lidar: lidar, lambda camera: camera.model_copy(update={"cast": None}))
    turn, (columns, rows) = _STEPS[name]
    return _changed(
        rig, lambda lidar: _fewer_azimuths(lidar, turn), lambda camera: _thinned(camera, columns, rows)
    )


def _changed(rig: Rig, lidar: Callable[[Lidar], Lidar], camera: Callable[[Camera], Camera]) -> Rig:
    changes: dict[type[Sensor], Callable[[Any], Sensor]] = {Lidar: lidar, Camera: camera}
    sensors = tuple(changes[type(s)](s) if type(s) in changes else s for s in rig.sensors)
    return rig.model_copy(update={"sensors": sensors})


def _fewer_azimuths(lidar: Lidar, step: int) -> Lidar:
    azimuths_deg = tuple(float(azimuth) for azimuth in lidar.azimuths()[::step])
    return lidar.model_copy(update={"azimuths_deg": azimuths_deg})


def _thinned(camera: Camera, columns: int, rows: int) -> Camera:
    """Every second or fourth ray per side; the principal point moves so that they stay where they were."""
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    width, height = camera.resolution
    cast = (max(1, width // columns), max(1, height // rows))
    if width % columns == 0:
        cx_px += (columns - 1) / 2 * camera.image[0] / width
    if height % rows == 0:
        cy_px += (rows - 1) / 2 * camera.image[1] / height
    fields = {"fx": fx_px, "fy": fy_px, "cx": cx_px, "cy": cy_px, "hfov_deg": None}
    return camera.model_copy(update={"cast": cast, **fields})


def ray_count(rig: Rig) -> int:
    """Rays of all enabled sensors."""
    return sum(sensor.ray_count for sensor in rig.sensors if sensor.enabled)


def has_all_pixels(rig: Rig) -> bool:
    """Return whether every camera casts a ray per pixel already (or there is none)."""
    return all(camera.resolution == camera.image for camera in rig.enabled_cameras())
