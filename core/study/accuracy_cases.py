"""Methods compared in the accuracy study: each scores one rig on one grid, and is ready to be timed.

A case is prepared (not timed), run (timed: from the rig to S-MS of all classes) and says what it covered.
Everything that belongs to the scene alone - POG, entropies, dense grids, lists of voxels - is ready before,
and so are the rays of plain DDA; the engine makes its rays within its time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.caster import RAYS_PER_CHUNK, Caster
from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.kernels.rays.cast import add_marks, mark_rays
from riglens.core.kernels.runtime import jit
from riglens.core.kernels.voxels import update_coverage
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings, s_ms
from riglens.core.metric.scoring import score
from riglens.core.rig.model import Camera, Lidar, Rig, Sensor
from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.scene.columns import Words, unpack
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


@dataclass(frozen=True)
class Case:
    """One way of scoring the rig: `prepare` does what must not count towards the time, `run` scores with what it made,
    and `answer` says what a run found."""

    prepare: Callable[[], Any]
    run: Callable[[Any], Any]
    answer: Callable[[Any], Answer]

    def answered(self) -> Answer:
        """Return what a run finds."""
        return self.answer(self.run(self.prepare()))


def engine_case(
    field: EntropyField, rig: Rig, settings: MetricSettings, threads: int | None, before: Rig | None = None
) -> Case:
    """Return the engine, fresh, or holding the rig as it was before an edit."""

    def prepare() -> Engine:
        engine = Engine(field, threads)
        if before is not None:
            engine.evaluate(before, settings)
        return engine

    def answer(found: Evaluation) -> Answer:
        seen = np.zeros(field.index.count, np.uint8)
        for kind, flag in FLAGS.items():
            seen[_is_in(field, found.seen[kind])] |= np.uint8(flag)
        return Answer(tuple(found.scores.classes[cls].s_ms for cls in CLASSES), seen)

    return Case(prepare, lambda engine: engine.evaluate(rig, settings), answer)


def plain_case(
    field: EntropyField,
    rig: Rig,
    camera_weight: float,
    real: type[np.floating[Any]],
    dda: PlainDda | None = None,
    step_voxels: float | None = None,
) -> Case:
    """Return the case of plain DDA on one thread, in double or in single precision; with a step, points on the rays
    instead.

    Clearing the dense grid counts towards the time. Cases may share the dense grids of one `dda`.
    """
    grids = dda or PlainDda(field)
    every = [grid_rays(sensor, field.grid, real) for sensor in rig.sensors if sensor.enabled]

    def run(_: None) -> NDArray[np.float64]:
        grids.clear()
        for rays in every:
            if step_voxels is None:
                grids.cast(rays)
            else:
                grids.sample(rays, step_voxels)
        return grids.sums()

    def answer(sums: NDArray[np.float64]) -> Answer:
        ix, iy, iz = field.index.ijk().T
        by_camera, by_lidar = (seen[ix, iy, iz] for seen in grids.seen)
        flags = by_camera * np.uint8(FLAGS["camera"]) | by_lidar * np.uint8(FLAGS["lidar"])
        return Answer(_s_ms(sums, camera_weight), flags)

    return Case(lambda: None, run, answer)


def walk_case(field: EntropyField, sensor: Sensor, settings: MetricSettings, threads: int) -> Case:
    """Return the case of the exact walk, ray by ray over one sensor, and the engine's own sum: the slow way to its
    answer."""
    caster, kinds = Caster(field, threads), kind_names()
    kind, keep = kinds.index(sensor.kind), field.index.words

    def prepare() -> list[Words]:
        return [np.zeros((count, keep.size), np.uint64) for count in (1, len(kinds), caster.workers - 1)]

    def run(sets: list[Words]) -> tuple[NDArray[np.int64], Words]:
        """Walk all rays, then settle one set against nothing; return sums (kinds + 1, 4), and the voxels."""
        stack, union, spare = sets
        jit.use_threads(caster.workers)
        rays, marks = caster.rays(sensor, "exact"), stack[0]
        count = len(rays.rows) * len(rays.planes)
        for start in range(0, count, RAYS_PER_CHUNK):
            end = min(start + RAYS_PER_CHUNK, count)
            left = np.ones(end - start, np.bool_)
            mark_rays(rays, start, end, marks, spare, left)
            for word, bit in caster.walk_irregular(rays, start + np.flatnonzero(left)):
                marks[word] |= bit
        add_marks(spare, marks, caster.workers)
        nx = field.grid.shape[0]
        region = update_coverage.Region(0, nx, 0, keep.size // nx, keep.size // nx)
        slots = update_coverage.Slots(np.zeros(1, np.int64), np.zeros(0, np.int64))
        sums_q = np.zeros((len(kinds) + 1, update_coverage.COLUMNS), np.int64)
        sums_q[kind], sums_q[-1] = update_coverage.settle(
            stack, union, keep, slots, np.array([kind]), region, field.entropies, caster.workers
        )
        return sums_q, union[kind]

    def answer(found: tuple[NDArray[np.int64], Words]) -> Answer:
        sums_q, words = found
        classes, seen = score(field, sums_q, settings).classes, np.zeros(field.index.count, np.uint8)
        seen[_is_in(field, words)] = FLAGS[sensor.kind]
        return Answer(tuple(classes[cls].s_ms for cls in CLASSES), seen)

    return Case(prepare, run, answer)


def voxel_case(
    tests: VoxelTests, rig: Rig, camera_weight: float, test: Literal["rectangles", "centres"]
) -> Case:
    """Return the case of one of the two tests voxel by voxel."""
    cover = tests.bounding_rectangles if test == "rectangles" else tests.centres_in_view

    def run(_: None) -> tuple[Seen, NDArray[np.float64]]:
        seen = cover(rig)
        return seen, tests.sums(seen)

    return Case(lambda: None, run, lambda found: Answer(_s_ms(found[1], camera_weight), found[0]))


def timed(
    cases: Sequence[Case], repetitions: int, progress: Progress | None = None
) -> tuple[list[Answer], list[list[float]]]:
    """Return the answers of a warm-up round, then the times in ms of alternating repetitions; a case longer than
    SLOW_MS runs once."""
    answers: list[Answer] = []
    times: list[list[float]] = [[] for _ in cases]
    for repetition in range(repetitions + 1):
        for number, case in enumerate(cases):
            if repetition > 1 and times[number][0] > SLOW_MS:
                continue
            ready = case.prepare()
            started = time.perf_counter()
            found = case.run(ready)
            elapsed_ms = (time.perf_counter() - started) * 1e3
            if repetition == 0:
                answers.append(case.answer(found))
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


def _is_in(field: EntropyField, words: Words) -> NDArray[np.bool_]:
    """Return whether each informative voxel, in the order of their ids, is in a set of them, (n,)."""
    return unpack(field.grid, words)[unpack(field.grid, field.index.words)]


def moved(rig: Rig, sensor: Sensor) -> Rig:
    """Return the rig with one sensor 0.1 m further to the front and left, where an edit may have found it."""
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
        native = (s.model_copy(update={"cast": None}) if isinstance(s, Camera) else s for s in rig.sensors)
        return rig.model_copy(update={"sensors": tuple(native)})
    turn, (columns, rows) = _STEPS[name]
    sensors: list[Sensor] = []
    for sensor in rig.sensors:
        if isinstance(sensor, Lidar):
            azimuths_deg = tuple(float(azimuth) for azimuth in sensor.azimuths()[::turn])
            sensors.append(sensor.model_copy(update={"azimuths_deg": azimuths_deg}))
        else:
            sensors.append(_thinned(sensor, columns, rows) if isinstance(sensor, Camera) else sensor)
    return rig.model_copy(update={"sensors": tuple(sensors)})


def _thinned(camera: Camera, columns: int, rows: int) -> Camera:
    """Keep every second or fourth ray per side; the principal point moves so that they stay where they were."""
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
    """Return the rays of all enabled sensors."""
    return sum(sensor.ray_count for sensor in rig.sensors if sensor.enabled)


def has_all_pixels(rig: Rig) -> bool:
    """Return whether every camera casts a ray per pixel already (or there is none)."""
    return all(camera.resolution == camera.image for camera in rig.enabled_cameras())
