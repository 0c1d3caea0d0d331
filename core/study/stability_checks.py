"""Cases of the stability study on the whole evaluation, and the run over all of its cases.

Threads, edits, entropies, symmetry. As a program, this module prints a hash of everything that the engine says,
once per number of threads named on the command line: the number of threads that a process may start is fixed
when Numba starts.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from decimal import Decimal, localcontext

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.errors import InputError
from riglens.core.metric.entropy import QUANTA_PER_NAT, EntropyField
from riglens.core.metric.scores import METHODS, READINGS, MetricSettings, Scores
from riglens.core.rig.model import Lidar, Rig, Sensor
from riglens.core.scene.boxes import CLASSES, DataReport, Progress
from riglens.core.scene.columns import VoxelIndex, pack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.study.reference import Mask, exact_cover
from riglens.core.study.stability_cases import OPEN_ROAD, UNIT, RayCase, camera, ray_cases, spinning
from riglens.core.study.stability_edits import field_of, random_counts, random_edits
from riglens.core.study.stability_methods import (
    NOT_APPLICABLE,
    MethodName,
    MethodRow,
    Outcome,
    engine_cover,
    full_field,
    judged,
    plain_cover,
    rig_of,
)

EDITS, QUICK_EDITS = 1000, 100
THREADS = (1, 2, 8)
SEED = 7
HALF_QUANTUM_NAT = 0.5 / QUANTA_PER_NAT
GENERIC: tuple[Sensor, ...] = (
    spinning((0.31, 0.17, 4.23), (3.0, -2.0, 11.0)),
    camera((-1.3, 0.4, 3.4), (1.0, 4.0, 77.0)),
)


Job = Callable[[Progress], MethodRow]


def method_rows(
    quick: bool = False, edits: int = EDITS, threads: int | None = None, progress: Progress | None = None
) -> tuple[MethodRow, ...]:
    """Run every case of part 1; `progress` gets the fraction done."""
    jobs = [*_jobs(quick, edits, threads)]
    rows = []
    for number, job in enumerate(jobs):

        def part(fraction: float, done: int = number) -> None:
            if progress is not None:
                progress((done + fraction) / len(jobs))

        rows.append(job(part))
        part(1.0)
    return tuple(rows)


def _jobs(quick: bool, edits: int, threads: int | None) -> Iterator[Job]:
    for case in ray_cases(quick):
        yield _judging(case, threads)
    for check in check_rows(threads):
        yield _checking(check)
    yield lambda progress: random_edits(edits, progress)


def _judging(case: RayCase, threads: int | None) -> Job:
    return lambda progress: judged(case, threads, progress)


def _checking(check: Callable[[], MethodRow]) -> Job:
    return lambda _: check()


def check_rows(threads: int | None = None) -> Iterator[Callable[[], MethodRow]]:
    """The checks one by one, in the order of the table, without the random edits."""
    yield refused_grid
    yield same_on_all_threads
    yield extreme_probabilities
    yield one_frame
    yield lambda: no_sensors(threads)
    yield lambda: identical_sensors(threads)
    yield lambda: mirrored_twin(threads)


def _row(case: str, why: str, exact: str, fast: Outcome, **others: Outcome) -> MethodRow:
    outcomes: dict[MethodName, Outcome] = {
        "fast": fast,
        "plain": others.get("plain", NOT_APPLICABLE),
        "bresenham": others.get("bresenham", NOT_APPLICABLE),
    }
    return MethodRow(case, why, exact, outcomes)


def _ok_if(good: bool, right: str, wrong: str) -> Outcome:
    return Outcome("ok", right) if good else Outcome("fails", wrong)


# ---------------------------------------------------------------- settings


def refused_grid() -> MethodRow:
    """Try an edge that does not divide the ROI: the ROI must not be rounded silently."""
    try:
        VoxelGrid(0.35)
        fast = Outcome("fails", "accepted")
    except InputError as error:
        fast = _ok_if("must be a multiple" in error.message, "refused", str(error))
    lost_m = 60.0 - int(60.0 / 0.35) * 0.35
    plain = Outcome("fails", f"ROI cut by {lost_m:.2f} m")
    return _row(
        "δ = 0.35 m, ROI of 60 m",
        "171.4 voxels: cutting off the rest, as an integer division does, scores another ROI",
        "no such grid",
        fast,
        plain=plain,
    )


# ---------------------------------------------------------------- threads


def same_on_all_threads() -> MethodRow:
    """Compare the answers of 1, 2 and 8 threads, in a process that may start that many."""
    environment = {**os.environ, "NUMBA_NUM_THREADS": str(max(THREADS))}
    command = [sys.executable, "-m", "riglens.core.study.stability_checks", *map(str, THREADS)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    digests = done.stdout.split()
    different = len(set(digests)) - 1
    wrong = f"{different + 1} answers" if digests else "no answer"
    fast = _ok_if(len(digests) == len(THREADS) and different == 0, "bit-identical", wrong)
    return _row(
        "1, 2 and 8 threads",
        "threads finish in any order; sums of doubles depend on it",
        "one answer",
        fast,
        plain=Outcome("n.a.", "one thread"),
    )


def digest(threads: int) -> str:
    """SHA-256 over scores and covered voxels of some rigs by all methods and readings."""
    field = field_of(OPEN_ROAD, random_counts(OPEN_ROAD, np.random.default_rng(1)))
    upright = (spinning((0.3, 0.2, 2.17)), camera((1.1, -0.6, 1.8), (0.0, 0.0, 40.0), (352, 128)))
    tilted = (spinning((-0.4, 0.6, 2.2), (16.0, 3.0, 0.0)), camera((0.0, 0.5, 1.8), (1.0, 9.0, 200.0)))
    engine, everything = Engine(field, threads), hashlib.sha256()
    for rig in (rig_of(upright), rig_of((*upright, *tilted)), rig_of(tilted)):
        for settings in (MetricSettings(method, reading) for method in METHODS for reading in READINGS):
            found = engine.evaluate(rig, settings)
            if found.threads != threads:
                raise RuntimeError(f"{found.threads} threads used, {threads} asked for")
            everything.update(repr(found.scores).encode())
            everything.update(found.seen["camera"].tobytes())
            everything.update(found.seen["lidar"].tobytes())
    return everything.hexdigest()


# ---------------------------------------------------------------- probabilities


def pog_of(grid: VoxelGrid, counts: NDArray[np.int64], frames: int) -> Pog:
    """A POG with the given counts (nx, ny, nz) for every class."""
    index = VoxelIndex.of(grid, pack(grid, counts > 0))
    i, j, k = index.ijk().T
    columns = np.repeat(counts[i, j, k, None], len(CLASSES), axis=1).astype(np.uint32)
    return Pog(grid, DataReport("made up", frames, dict.fromkeys(CLASSES, 1)), index, columns)


def entropy_nat(count: int, frames: int) -> Decimal:
    """h of p = count / frames with 50 digits."""
    with localcontext() as context:
        context.prec = 50
        if count in (0, frames):
            return Decimal(0)
        p, q = Decimal(count) / frames, Decimal(frames - count) / frames
        return -(p * p.ln()) - q * q.ln()


def extreme_probabilities() -> MethodRow:
    """Check the entropies of p from 10^-7 to 1 - 10^-7 with T = 10^7."""
    frames = 10**7
    counts = np.array([1, 2, 5, 100, 12_345, 5_000_000, 9_999_900, 9_999_998, 9_999_999, frames])
    grid = VoxelGrid(1.0, (float(counts.size), 1.0, 1.0))
    field = EntropyField.from_pog(pog_of(grid, counts.reshape(-1, 1, 1), frames))
    true = [entropy_nat(int(count), frames) for count in counts[:-1]]
    kept = field.index.count == len(true)
    worst = max(abs(float(Decimal(h) - t)) for h, t in zip(field.entropy_nat(0).tolist(), true, strict=True))
    fast = _ok_if(kept and worst <= 1.01 * HALF_QUANTUM_NAT, f"{worst:.1e} nat off", f"{worst:.1e} nat off")
    p = (counts[:-1] / frames).astype(np.float32)
    single = -p * np.log(p) - (1 - p) * np.log(1 - p)
    errors = [abs(float(h) / float(t) - 1.0) for h, t in zip(single, true, strict=True)]
    return _row(
        "p near 0 and 1, T = 10⁷",
        "1 − p in single precision keeps one digit of p = 0.0000001; counts overflow 16 bits",
        "h to 50 digits",
        fast,
        plain=Outcome("fails", f"float32: {max(errors):.0%} off"),
    )


def one_frame() -> MethodRow:
    """Check T = 1: every voxel is always or never occupied, so there is no entropy, and no NaN either."""
    grid = UNIT
    counts = np.zeros(grid.shape, np.int64)
    counts[2:6, 3:5, :4] = 1
    field = EntropyField.from_pog(pog_of(grid, counts, 1))
    found = Engine(field).evaluate(rig_of(GENERIC))
    figures = [(c.h_total, c.s_ms, c.any_seen) for c in found.scores.classes.values()]
    fast = _ok_if(set(figures) == {(0.0, 0.0, 0.0)}, "H(Ω) = 0", f"{figures}")
    with np.errstate(all="ignore"):
        p = counts.astype(np.float32)
        plain = -p * np.log(p) - (1 - p) * np.log(1 - p)
    nothing = Outcome("fails", "NaN") if np.isnan(plain.sum()) else Outcome("ok", "0")
    return _row(
        "a single frame, T = 1",
        "p is 0 or 1 everywhere: 0 · ln 0 is no number",
        "no entropy",
        fast,
        plain=nothing,
    )


# ---------------------------------------------------------------- rigs


def no_sensors(threads: int | None) -> MethodRow:
    """Check that a rig without sensors sees nothing."""
    found = Engine(full_field(UNIT), threads).evaluate(Rig(name="empty"))
    seen = found.scores.covered_voxels["any"]
    scores = {c.s_ms for c in found.scores.classes.values()}
    fast = _ok_if(seen == 0 and scores == {0.0}, "S-MS = 0", f"{seen} voxels, S-MS {scores}")
    return _row("an empty rig", "nothing to loop over", "0 voxels", fast)


def identical_sensors(threads: int | None) -> MethodRow:
    """Check that a sensor with a copy covers the same as alone, also after the copy is removed."""
    field, exact = full_field(UNIT), exact_cover(UNIT, GENERIC)
    alone, twice = rig_of(GENERIC), rig_of((*GENERIC, *GENERIC))
    engine = Engine(field, threads)
    answers = [engine.evaluate(rig) for rig in (alone, twice, alone)]
    same = len({repr(answer.scores) for answer in answers}) == 1
    plain_same = bool((plain_cover(UNIT, GENERIC) == plain_cover(UNIT, (*GENERIC, *GENERIC))).all())
    bresenham = [engine_cover(field, rig, "bresenham", threads) for rig in (alone, twice)]
    return _row(
        "identical sensors",
        "a voxel counts once, however many rays meet it",
        f"{int(exact.sum()):,} voxels",
        _ok_if(same, "as alone", "differs"),
        plain=_ok_if(plain_same, "as alone", "differs"),
        bresenham=_ok_if(bool((bresenham[0] == bresenham[1]).all()), "as alone", "differs"),
    )


def mirrored(sensor: Sensor) -> Sensor:
    """Return the sensor's mirror image in the plane y = 0: the same rays with y negated."""
    (x, y, z), (roll, pitch, yaw) = sensor.position, sensor.rpy_deg
    changes: dict[str, object] = {"position": (x, -y, z), "rpy_deg": (-roll, pitch, -yaw)}
    if isinstance(sensor, Lidar):
        changes["azimuths_deg"] = tuple(-float(angle) for angle in sensor.azimuths())
    image: Sensor = sensor.replace(**changes)
    return image


def mirrored_twin(threads: int | None) -> MethodRow:
    """Check that a mirrored scene and rig score the same, with covers that mirror each other."""
    counts, images = random_counts(UNIT, np.random.default_rng(SEED)), tuple(map(mirrored, GENERIC))
    scenes = field_of(UNIT, counts), field_of(UNIT, counts[:, ::-1])
    rigs = rig_of(GENERIC), rig_of(images)
    full = full_field(UNIT)

    def outcome(cover: Callable[[int], Mask]) -> Outcome:
        different = int((cover(0)[:, ::-1] != cover(1)).sum())
        return _ok_if(different == 0, "mirrored", f"{different:,} differ")

    scores = [_scores(scene, rig, threads) for scene, rig in zip(scenes, rigs, strict=True)]
    fast = outcome(lambda side: engine_cover(full, rigs[side], "exact", threads))
    if scores[0] != scores[1]:
        fast = Outcome("fails", "scores differ")
    return _row(
        "mirrored scene and rig",
        "left and right must score alike (no ray in a face: that would belong to the positive side of both)",
        outcome(lambda side: exact_cover(UNIT, (GENERIC, images)[side])).text,
        fast,
        plain=outcome(lambda side: plain_cover(UNIT, (GENERIC, images)[side])),
        bresenham=outcome(lambda side: engine_cover(full, rigs[side], "bresenham", threads)),
    )


def _scores(field: EntropyField, rig: Rig, threads: int | None) -> Scores:
    found = Engine(field, threads).evaluate(rig)
    return found.scores


if __name__ == "__main__":
    for count in sys.argv[1:]:
        print(digest(int(count)))
