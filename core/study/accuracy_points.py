"""What the accuracy study finds: a point per method, voxel edge and ray lattice, and all of them as CSV."""

from __future__ import annotations

import csv
import io
import statistics
from dataclasses import dataclass
from typing import Literal, NamedTuple

from riglens.core.metric.scores import DEFAULT_LAMBDA
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.cases import LatticeName

MethodName = Literal[
    "exact", "edit-camera", "edit-lidar", "plain", "plain-single", "bresenham", "rectangles", "centres"
]
TITLES: dict[MethodName, str] = {
    "exact": "exact engine",
    "edit-camera": "exact engine, one camera moved",
    "edit-lidar": "exact engine, one LiDAR moved",
    "plain": "plain DDA",
    "plain-single": "plain DDA, single precision",
    "bresenham": "Bresenham",
    "rectangles": "bounding rectangles",
    "centres": "voxel centres in view",
}
REPETITIONS = 5
LATTICES: tuple[LatticeName, ...] = ("1/2", "1/4", "1/8", "all pixels")


@dataclass(frozen=True)
class Plan:
    """What is measured, and how: repetitions of each case, threads (all by default), which lattices."""

    repetitions: int = REPETITIONS
    threads: int | None = None
    camera_weight: float = DEFAULT_LAMBDA
    lattices: tuple[LatticeName, ...] = LATTICES


class Wrong(NamedTuple):
    """Missed and extra voxels as shares of the exact set, per kind of sensor and together."""

    missed_camera: float
    missed_lidar: float
    missed: float
    extra_camera: float
    extra_lidar: float
    extra: float


@dataclass(frozen=True)
class Point:
    """One (method, voxel edge, ray lattice): its times and its errors.

    wrong: None on other grids than the study's own, where it is 0 by definition. Per class, None where
    H(Omega) or the reference is 0: `share` = -S-MS / H(Omega), `grid_error` and `shortcut_error` as parts of
    the reference's share, `raw_error` = |S-MS - reference| / |reference| in nats, as it stands.
    """

    method: MethodName
    voxel_m: float
    lattice: LatticeName
    rays: int
    threads: int
    times_ms: tuple[float, ...]
    s_ms: dict[str, float]
    wrong: Wrong | None
    share: dict[str, float | None]
    grid_error: dict[str, float | None]
    shortcut_error: dict[str, float | None]
    raw_error: dict[str, float | None]
    on_voxel_front: bool = False
    on_score_front: bool = False

    @property
    def median_ms(self) -> float:
        """Median time."""
        return statistics.median(self.times_ms)

    @property
    def from_scratch(self) -> bool:
        """Whether the whole rig is cast within the time; edits are not, and stand outside the fronts."""
        return not self.method.startswith("edit")

    @property
    def voxel_error(self) -> float | None:
        """Missed and extra voxels together."""
        return None if self.wrong is None else self.wrong.missed + self.wrong.extra

    @property
    def score_error(self) -> float:
        """Error of S-MS / H(Omega) of the worst class, grid and shortcut added."""
        pairs = zip(self.grid_error.values(), self.shortcut_error.values(), strict=True)
        return max((grid + cut for grid, cut in pairs if grid is not None and cut is not None), default=0.0)

    @property
    def is_own(self) -> bool:
        """Whether this is the exact engine with the rig's own rays."""
        return self.method == "exact" and self.lattice == "own"


@dataclass(frozen=True)
class Study:
    """All points; shortcuts are compared on the grid `voxel_m`, scores are held to the grid `finest_m`."""

    rig: Rig
    source: str
    frames: int
    voxel_m: float
    finest_m: float
    plan: Plan
    points: tuple[Point, ...]

    @property
    def own(self) -> Point:
        """The point in question: exact, on the study's own grid, with the rig's own rays."""
        return next(p for p in self.points if p.is_own and p.voxel_m == self.voxel_m)

    @property
    def finest(self) -> Point:
        """The reference of the scores."""
        return next(p for p in self.points if p.is_own and p.voxel_m == self.finest_m)

    def to_csv(self) -> str:
        """All points as CSV, full precision; empty where a figure does not exist."""
        text = io.StringIO()
        rows = [_csv_row(point) for point in self.points]
        writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        return text.getvalue()


def _csv_row(point: Point) -> dict[str, object]:
    wrong = point.wrong or (None,) * len(Wrong._fields)
    row: dict[str, object] = {
        "method": point.method,
        "voxel_m": point.voxel_m,
        "lattice": point.lattice,
        "rays": point.rays,
        "threads": point.threads,
        "median_ms": point.median_ms,
        "least_ms": min(point.times_ms),
        "most_ms": max(point.times_ms),
        "runs": len(point.times_ms),
        **dict(zip(Wrong._fields, wrong, strict=True)),
    }
    for cls in CLASSES:
        row |= {
            f"s_ms_{cls}": point.s_ms[cls],
            f"share_{cls}": point.share[cls],
            f"grid_error_{cls}": point.grid_error[cls],
            f"shortcut_error_{cls}": point.shortcut_error[cls],
            f"raw_error_{cls}": point.raw_error[cls],
        }
    row |= {"score_error": point.score_error, "from_scratch": point.from_scratch}
    row |= {"on_voxel_front": point.on_voxel_front, "on_score_front": point.on_score_front}
    return {name: "" if value is None else value for name, value in row.items()}
