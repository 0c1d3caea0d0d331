"""Judge the methods of the stability study: on rays, against rational arithmetic, and on the whole evaluation.

As a program, this module prints a hash of everything that the engine says, once per number of threads named on the
command line: the number of threads that a process may start is fixed when Numba starts.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from decimal import Decimal, localcontext
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.errors import InputError
from riglens.core.kernels.rays import plain
from riglens.core.metric.entropy import QUANTA_PER_NAT, EntropyField
from riglens.core.metric.scores import METHODS, READINGS, Method, MetricSettings
from riglens.core.rig.model import Lidar, Rig, Sensor
from riglens.core.scene.boxes import CLASSES, DataReport, Progress
from riglens.core.scene.columns import VoxelIndex, pack, unpack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.study.reference import Mask, exact_cover
from riglens.core.study.simple_methods import grid_rays
from riglens.core.study.stability_cases import OPEN_ROAD, UNIT, RayCase, camera, spinning

MethodName = Literal["fast", "plain", "bresenham"]
METHOD_NAMES: tuple[MethodName, ...] = ("fast", "plain", "bresenham")
Verdict = Literal["ok", "fails", "n.a."]
FRAMES = 1000
THREADS = (1, 2, 8)
SEED = 7
HALF_QUANTUM_NAT = 0.5 / QUANTA_PER_NAT
GENERIC: tuple[Sensor, ...] = (
    spinning((0.31, 0.17, 4.23), (3.0, -2.0, 11.0)),
    camera((-1.3, 0.4, 3.4), (1.0, 4.0, 77.0)),
)


class Outcome(NamedTuple):
    """Outcome of a method: the verdict, in words, and voxels found, missed and extra if counted."""

    verdict: Verdict
    says: str
    voxels: int | None = None
    missed: int | None = None
    extra: int | None = None

    @classmethod
    def of(cls, is_right: bool, right: str, wrong: str) -> Outcome:
        """Return the outcome of a method that is right or not."""
        return cls("ok", right) if is_right else cls("fails", wrong)


NOT_APPLICABLE = Outcome("n.a.", "n.a.")


class MethodRow(NamedTuple):
    """Case: why it breaks simple methods, the right answer, the results of the methods, rays cast."""

    case: str
    why: str
    exact: str
    outcomes: Mapping[MethodName, Outcome]
    rays: int | None = None


def row(
    case: str,
    why: str,
    exact: str,
    fast: Outcome,
    plain: Outcome = NOT_APPLICABLE,
    bresenham: Outcome = NOT_APPLICABLE,
    rays: int | None = None,
) -> MethodRow:
    """Return the row of a case."""
    return MethodRow(case, why, exact, {"fast": fast, "plain": plain, "bresenham": bresenham}, rays)


# ---------------------------------------------------------------- rays


def rig_of(sensors: tuple[Sensor, ...]) -> Rig:
    """Return a rig of sensors, numbered so that their names are unique."""
    named = (sensor.replace(name=f"{n} {sensor.kind}") for n, sensor in enumerate(sensors, 1))
    return Rig(name="study", sensors=tuple(named))


def field_of(grid: VoxelGrid, counts: NDArray[np.int64], frames: int = FRAMES) -> EntropyField:
    """Return the entropies of occupied-frame counts: (nx, ny, nz, 3), or (nx, ny, nz) if equal for all classes."""
    by_class = np.broadcast_to(counts.reshape(*grid.shape, -1), (*grid.shape, len(CLASSES)))
    index = VoxelIndex.of(grid, pack(grid, np.asarray(by_class.any(axis=-1))))
    i, j, k = index.ijk().T
    data = DataReport("made up", frames, dict.fromkeys(CLASSES, 1))
    return EntropyField.from_pog(Pog.of(grid, data, index, by_class[i, j, k].astype(np.uint32)))


def random_counts(grid: VoxelGrid, rng: np.random.Generator) -> NDArray[np.int64]:
    """Return random counts out of FRAMES, (nx, ny, nz, 3), not 0 in 30 % of the voxels per class."""
    shape = (*grid.shape, len(CLASSES))
    drawn: NDArray[np.int64] = rng.integers(1, FRAMES, shape) * (rng.random(shape) < 0.3)
    return drawn


def engine_cover(
    grid: VoxelGrid, sensors: tuple[Sensor, ...], method: Method = "exact", threads: int | None = None
) -> Mask:
    """Return the voxels (nx, ny, nz) that the engine finds where every voxel counts."""
    field = field_of(grid, np.ones(grid.shape, np.int64), 2)
    found = Engine(field, threads).evaluate(rig_of(sensors), MetricSettings(method=method))
    return unpack(grid, found.seen_by_any())


def plain_cover(grid: VoxelGrid, sensors: tuple[Sensor, ...]) -> Mask:
    """Return the voxels (nx, ny, nz) that plain DDA finds."""
    seen = np.zeros(grid.shape, np.uint8)
    for sensor in sensors:
        rays = grid_rays(sensor, grid)
        plain.walk_dense(rays.origin, rays.directions, rays.near, rays.far, 1, seen)
    found: Mask = seen != 0
    return found


def compared(found: Mask, exact: Mask) -> Outcome:
    """Return the verdict on a set of voxels."""
    missed, extra = int((exact & ~found).sum()), int((found & ~exact).sum())
    parts = [f"{missed:,} missed"] * (missed > 0) + [f"{extra:,} extra"] * (extra > 0)
    return Outcome("fails" if parts else "ok", ", ".join(parts) or "ok", int(found.sum()), missed, extra)


def judged(case: RayCase, threads: int | None = None, progress: Progress | None = None) -> MethodRow:
    """Compare all methods on one case with the voxels that rational arithmetic finds."""
    exact = exact_cover(case.grid, case.sensors, progress)
    return row(
        case.name,
        case.why,
        f"{int(exact.sum()):,} voxels",
        fast=compared(engine_cover(case.grid, case.sensors, "exact", threads), exact),
        plain=compared(plain_cover(case.grid, case.sensors), exact),
        bresenham=compared(engine_cover(case.grid, case.sensors, "bresenham", threads), exact),
        rays=sum(sensor.ray_count for sensor in case.sensors),
    )


# ---------------------------------------------------------------- the whole evaluation


def refused_grid(_: int | None = None) -> MethodRow:
    """Try an edge that does not divide the ROI: the ROI must not be rounded silently."""
    try:
        VoxelGrid(0.35)
        fast = Outcome("fails", "accepted")
    except InputError as error:
        fast = Outcome.of("must be a multiple" in error.message, "refused", str(error))
    lost_m = 60.0 - int(60.0 / 0.35) * 0.35
    return row(
        "δ = 0.35 m, ROI of 60 m",
        "171.4 voxels: cutting off the rest, as an integer division does, scores a different ROI",
        "no such grid",
        fast,
        plain=Outcome("fails", f"ROI cut by {lost_m:.2f} m"),
    )


def same_on_all_threads(_: int | None = None) -> MethodRow:
    """Compare the answers of 1, 2 and 8 threads, in a process that may start that many."""
    environment = {**os.environ, "NUMBA_NUM_THREADS": str(max(THREADS))}
    command = [sys.executable, "-m", __name__, *map(str, THREADS)]
    done = subprocess.run(command, env=environment, capture_output=True, encoding="utf-8", check=False)
    digests = done.stdout.split()
    wrong = f"{len(set(digests))} answers" if digests else "no answer"
    return row(
        "1, 2 and 8 threads",
        "threads finish in any order; sums of doubles depend on it",
        "one answer",
        Outcome.of(len(digests) == len(THREADS) and len(set(digests)) == 1, "bit-identical", wrong),
        plain=Outcome("n.a.", "one thread"),
    )


def digest(threads: int) -> str:
    """Return the SHA-256 of scores and covered voxels of some rigs by all methods and readings."""
    field = field_of(OPEN_ROAD, random_counts(OPEN_ROAD, np.random.default_rng(1)))
    upright = (spinning((0.3, 0.2, 2.17)), camera((1.1, -0.6, 1.8), (0.0, 0.0, 40.0), (352, 128)))
    tilted = (spinning((-0.4, 0.6, 2.2), (16.0, 3.0, 0.0)), camera((0.0, 0.5, 1.8), (1.0, 9.0, 200.0)))
    engine, everything = Engine(field, threads), hashlib.sha256()
    for sensors in (upright, (*upright, *tilted), tilted):
        for settings in (MetricSettings(method, reading) for method in METHODS for reading in READINGS):
            found = engine.evaluate(rig_of(sensors), settings)
            if found.threads != threads:
                raise RuntimeError(f"{found.threads} threads used, {threads} asked for")
            everything.update(repr(found.scores).encode())
            everything.update(found.seen["camera"].tobytes())
            everything.update(found.seen["lidar"].tobytes())
    return everything.hexdigest()


def entropy_nat(count: int, frames: int) -> Decimal:
    """Return h of p = count / frames with 50 digits."""
    with localcontext() as context:
        context.prec = 50
        if count in (0, frames):
            return Decimal(0)
        p, q = Decimal(count) / frames, Decimal(frames - count) / frames
        return -(p * p.ln()) - q * q.ln()


def extreme_probabilities(_: int | None = None) -> MethodRow:
    """Check the entropies of p from 10^-7 to 1 - 10^-7 with T = 10^7."""
    frames = 10**7
    counts = np.array([1, 2, 5, 100, 12_345, 5_000_000, 9_999_900, 9_999_998, 9_999_999, frames])
    field = field_of(VoxelGrid(1.0, (float(counts.size), 1.0, 1.0)), counts, frames)
    true = [entropy_nat(int(count), frames) for count in counts[:-1]]
    kept = field.index.count == len(true)
    worst = max(abs(float(Decimal(h) - t)) for h, t in zip(field.entropy_nat(0).tolist(), true, strict=True))
    p = (counts[:-1] / frames).astype(np.float32)
    single = -p * np.log(p) - (1 - p) * np.log(1 - p)
    errors = [abs(float(h) / float(t) - 1.0) for h, t in zip(single, true, strict=True)]
    return row(
        "p near 0 and 1, T = 10⁷",
        "1 − p in single precision keeps one digit of p = 0.0000001; counts overflow 16 bits",
        "h to 50 digits",
        Outcome.of(kept and worst <= 1.01 * HALF_QUANTUM_NAT, f"{worst:.1e} nat off", f"{worst:.1e} nat off"),
        plain=Outcome("fails", f"float32: {max(errors):.0%} off"),
    )


def one_frame(threads: int | None = None) -> MethodRow:
    """Check T = 1: every voxel is always or never occupied, so there is no entropy, and no NaN either."""
    counts = np.zeros(UNIT.shape, np.int64)
    counts[2:6, 3:5, :4] = 1
    found = Engine(field_of(UNIT, counts, 1), threads).evaluate(rig_of(GENERIC))
    figures = [(c.h_total, c.s_ms, c.any_seen) for c in found.scores.classes.values()]
    with np.errstate(all="ignore"):
        p = counts.astype(np.float32)
        plain = -p * np.log(p) - (1 - p) * np.log(1 - p)
    return row(
        "a single frame, T = 1",
        "p is 0 or 1 everywhere: 0 · ln 0 is not a number",
        "no entropy",
        Outcome.of(set(figures) == {(0.0, 0.0, 0.0)}, "H(Ω) = 0", f"{figures}"),
        plain=Outcome.of(not np.isnan(plain.sum()), "0", "NaN"),
    )


def no_sensors(threads: int | None = None) -> MethodRow:
    """Check that a rig without sensors sees nothing."""
    field = field_of(UNIT, np.ones(UNIT.shape, np.int64), 2)
    found = Engine(field, threads).evaluate(Rig(name="empty"))
    seen = found.scores.covered_voxels["any"]
    scores = {c.s_ms for c in found.scores.classes.values()}
    fast = Outcome.of(seen == 0 and scores == {0.0}, "S-MS = 0", f"{seen} voxels, S-MS {scores}")
    return row("an empty rig", "nothing to loop over", "0 voxels", fast)


def identical_sensors(threads: int | None = None) -> MethodRow:
    """Check that a sensor with a copy covers the same as alone, also after the copy is removed."""
    exact, twice = exact_cover(UNIT, GENERIC), (*GENERIC, *GENERIC)
    engine = Engine(field_of(UNIT, np.ones(UNIT.shape, np.int64), 2), threads)
    answers = [engine.evaluate(rig_of(sensors)) for sensors in (GENERIC, twice, GENERIC)]

    def alike(one: Mask, other: Mask) -> Outcome:
        return Outcome.of(np.array_equal(one, other), "as alone", "differs")

    return row(
        "identical sensors",
        "a voxel counts once, however many rays meet it",
        f"{int(exact.sum()):,} voxels",
        Outcome.of(len({repr(answer.scores) for answer in answers}) == 1, "as alone", "differs"),
        plain=alike(plain_cover(UNIT, GENERIC), plain_cover(UNIT, twice)),
        bresenham=alike(
            engine_cover(UNIT, GENERIC, "bresenham", threads), engine_cover(UNIT, twice, "bresenham", threads)
        ),
    )


def mirrored(sensor: Sensor) -> Sensor:
    """Return the sensor's mirror image in the plane y = 0: the same rays with y negated."""
    (x, y, z), (roll, pitch, yaw) = sensor.position, sensor.rpy_deg
    changes: dict[str, object] = {"position": (x, -y, z), "rpy_deg": (-roll, pitch, -yaw)}
    if isinstance(sensor, Lidar):
        changes["azimuths_deg"] = tuple(-float(angle) for angle in sensor.azimuths())
    image: Sensor = sensor.replace(**changes)
    return image


def mirrored_twin(threads: int | None = None) -> MethodRow:
    """Check that a mirrored scene and rig score the same, with covers that mirror each other."""
    counts, images = random_counts(UNIT, np.random.default_rng(SEED)), tuple(map(mirrored, GENERIC))

    def outcome(cover: Callable[[tuple[Sensor, ...]], Mask]) -> Outcome:
        different = int((cover(GENERIC)[:, ::-1] != cover(images)).sum())
        return Outcome.of(different == 0, "mirrored", f"{different:,} differ")

    pairs = ((counts, GENERIC), (counts[:, ::-1], images))
    one, other = (
        Engine(field_of(UNIT, found), threads).evaluate(rig_of(sensors)).scores for found, sensors in pairs
    )
    fast = outcome(lambda sensors: engine_cover(UNIT, sensors, "exact", threads))
    return row(
        "mirrored scene and rig",
        "left and right must score alike (no ray in a face: that would belong to the positive side of both)",
        outcome(lambda sensors: exact_cover(UNIT, sensors)).says,
        fast if one == other else Outcome("fails", "scores differ"),
        plain=outcome(lambda sensors: plain_cover(UNIT, sensors)),
        bresenham=outcome(lambda sensors: engine_cover(UNIT, sensors, "bresenham", threads)),
    )


CHECKS: tuple[Callable[[int | None], MethodRow], ...] = (
    refused_grid,
    same_on_all_threads,
    extreme_probabilities,
    one_frame,
    no_sensors,
    identical_sensors,
    mirrored_twin,
)
"""The checks of the whole evaluation, in the order of the table, each with a number of threads."""


if __name__ == "__main__":
    for count in sys.argv[1:]:
        print(digest(int(count)))
