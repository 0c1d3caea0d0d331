"""Blind zones: the lowest height that sensors see in each column around the car, and where objects are unseen.

A sensor sees an object of a height and width that stands somewhere if one of its rays certainly passes through it: the
lowest voxel that the sensor traverses in a column within the object's width lies wholly below the object's top.
Cameras count with all their pixels, whatever they cast elsewhere. Traffic plays no part. L_k is the height from which
on k sensors see such an object.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator
from scipy import ndimage

from riglens.core.blind.outline import BANDS_M, Outline
from riglens.core.engine.caster import Caster
from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.kernels.review import blind as kernel
from riglens.core.kernels.runtime import jit
from riglens.core.kernels.voxels.entropy_codes import Runs
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body
from riglens.core.option_help import OptionHelp
from riglens.core.rig.model import Rig, Sensor, Vehicle
from riglens.core.scene.boxes import DataReport
from riglens.core.scene.columns import VoxelIndex, empty_words, words_per_column
from riglens.core.scene.grid import DEFAULT_VOXEL_M, VoxelGrid
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.sensing.body_ends import Obstacle, obstacle_of
from riglens.core.sensors.registry import kind_named, kind_names, one_of
from riglens.core.vehicle.housings import car_of


def by_names() -> tuple[str, ...]:
    """Return the names of the groups of sensors that may count: any sensor, or those of one kind."""
    return ("any", *sorted(kind_names()))


def _known_by(name: str) -> str:
    return one_of(by_names(), name)


By = Annotated[str, AfterValidator(_known_by)]
"""Sensors that count: one of `by_names`."""
HEIGHTS_M = (0.15, 0.30, 0.80, 1.15, 1.80)
"""Heights of objects in the tables of areas: a kerb or a child's toy, a crawling child, the test cylinder of UN R158
and FMVSS 111, a child of six years, an adult. The selection is our choice."""
SHARE_WITHIN_M = 10.0
"""Distance within which the IIHS states the visible share of the ground (news of 26 June 2025); the height from which
ground counts as seen is our choice: the lowest of HEIGHTS_M."""
OVERLAP_HEIGHT_M = HEIGHTS_M[2]
"""Height of the object that sensors are counted for where fields of view overlap."""
WIDTH_M = 0.30
"""Width of such an object: that of the test cylinder of UN R158 and FMVSS 111."""
HEIGHT_M = 2.0
"""Height up to which columns are searched."""
NONE = np.iinfo(np.uint16).max
Levels = NDArray[np.uint16]
Flags = NDArray[np.bool_]
_EPSILON_M = 1e-9


@dataclass(frozen=True)
class BlindSettings:
    """Settings of blind zones; body: whether the car blocks rays."""

    voxel_m: Annotated[
        float, OptionHelp("M", "Edge of a voxel of blind zones, in metres.", "blind-voxel")
    ] = DEFAULT_VOXEL_M
    width_m: Annotated[
        float,
        OptionHelp("M", "Width of the object in metres; 0 for single columns of voxels.", "blind-width"),
    ] = WIDTH_M
    body: Body = "blocks"
    within_m: Annotated[
        float, OptionHelp("M", "Maximum distance from the car's outline, in metres.", "blind-within")
    ] = BANDS_M[-1]

    def __post_init__(self) -> None:
        if not 0.0 < self.voxel_m <= 1.0:
            raise InputError(f"must be above 0 and at most 1 m (got {self.voxel_m:g})", "voxel_m")
        if not 0.0 <= self.width_m <= 5.0:
            raise InputError(f"must be between 0 and 5 m (got {self.width_m:g})", "width_m")
        if not BANDS_M[1] <= self.within_m <= 100.0:
            raise InputError(f"must be between 1 and 100 m (got {self.within_m:g})", "within_m")

    @property
    def bands_m(self) -> tuple[float, ...]:
        """Return the edges of the distance bands, including the end of the last one."""
        return (*(edge for edge in BANDS_M if edge < self.within_m), self.within_m)


def grid_around(outline: Outline, settings: BlindSettings) -> VoxelGrid:
    """Return the voxels around a car up to the largest distance of objects; InputError for an edge that is too fine."""
    far = np.abs([outline.rear_m, outline.front_m, outline.right_m, outline.left_m])
    far = far + settings.within_m + settings.width_m / 2.0  # to the outer side of the farthest objects
    step = 2.0 * settings.voxel_m
    length, width = (step * math.ceil(float(side.max()) * 2.0 / step) for side in (far[:2], far[2:]))
    height = settings.voxel_m * max(1, round(HEIGHT_M / settings.voxel_m))
    grid = VoxelGrid(settings.voxel_m, (length, width, height))
    grid.require_memory(2.0, "blind zones")
    return grid


def whole_field(grid: VoxelGrid) -> EntropyField:
    """Return a field in which every voxel of the grid counts, and all count the same."""
    words, depth, levels = empty_words(grid), words_per_column(grid), grid.shape[2]
    for part in range(depth):
        words[part::depth] = np.uint64((1 << min(64, levels - 64 * part)) - 1)
    starts = np.ones(words.size, np.uint64)
    runs = Runs(starts, np.arange(words.size + 1, dtype=np.uint32), np.zeros(words.size, np.uint16))
    index = VoxelIndex.of(grid, words)
    data = DataReport("every voxel", 1, {})
    return EntropyField(grid, index, runs, np.ones((1, 4), np.uint32), data, (index.count,) * 3)


@dataclass(frozen=True)
class Ground:
    """Columns around a car that count: places of their centres along both axes, their sector and band (nx, ny), and
    whether they count: next to the outline and within the last band."""

    outline: Outline
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    distance_m: NDArray[np.float64]
    sector: NDArray[np.uint8]
    band: NDArray[np.int64]
    counts: Flags

    @classmethod
    def of(cls, grid: VoxelGrid, outline: Outline, bands_m: tuple[float, ...]) -> Ground:
        """Return the ground of a grid around an outline."""
        x, y = np.meshgrid(grid.centres_m(0), grid.centres_m(1), indexing="ij")
        distance = np.round(outline.distance_m(x, y), 9)
        band = np.searchsorted(np.array(bands_m), distance, side="left") - 1
        counts = (distance > _EPSILON_M) & (distance <= bands_m[-1])
        return cls(outline, grid.centres_m(0), grid.centres_m(1), distance, sector_of(x, y), band, counts)


@dataclass(frozen=True)
class Hole:
    """Largest connected patch of ground on which an object is unseen: its area, its middle, and its distance from the
    car."""

    area_m2: float
    x_m: float
    y_m: float
    nearest_m: float


@dataclass(frozen=True)
class BlindMap:
    """Lowest level seen in each column: levels uint16 (groups, 3, nx, ny) for `groups` of sensors, those of `by_names`
    that the rig has, and k = 1, 2, 3; NONE: never seen."""

    rig: Rig
    settings: BlindSettings
    grid: VoxelGrid
    ground: Ground
    groups: tuple[By, ...]
    levels: Levels

    def levels_of(self, by: By, k: int) -> Levels:
        """Return the lowest levels (nx, ny) that k sensors of a group see."""
        if by not in self.groups:
            return np.full(self.levels.shape[2:], NONE, np.uint16)
        return np.asarray(self.levels[self.groups.index(by), k - 1])

    def lowest_m(self, by: By = "any", k: int = 1) -> NDArray[np.float64]:
        """Return L_k (nx, ny): the height in metres from which on k sensors see an object; inf: none below the region's
        top.

        It is the top of the lowest voxel, so never less than what rays truly need, and up to an edge more.
        """
        levels = self.levels_of(by, k)
        return np.where(levels == NONE, np.inf, (levels + 1.0) * self.grid.voxel_m)

    def unseen(self, height_m: float, by: By = "any", k: int = 1) -> Flags:
        """Return where (nx, ny) an object of that height, by its middle, is seen by fewer than k sensors."""
        return np.asarray(self.ground.counts & (self.lowest_m(by, k) > height_m + _EPSILON_M))

    def steps(self, by: By = "any", k: int = 1) -> NDArray[np.uint8]:
        """Return the number of HEIGHTS_M at which an object at (nx, ny) is seen by fewer than k sensors: 0 is best."""
        tops = (np.arange(self.grid.shape[2]) + 1.0) * self.grid.voxel_m
        step_of = np.searchsorted(np.array(HEIGHTS_M), tops - _EPSILON_M).astype(np.uint8)
        step_of = np.append(step_of, np.uint8(len(HEIGHTS_M)))
        levels = np.minimum(self.levels_of(by, k), self.grid.shape[2])
        return np.asarray(step_of[levels], np.uint8)

    @property
    def column_m2(self) -> float:
        """Area of a column."""
        return self.grid.voxel_m**2

    def area_m2(self, height_m: float, by: By = "any", k: int = 1) -> NDArray[np.float64]:
        """Return the area in m² by sector and band (8, bands) on which an object of that height is unseen; less is
        better."""
        return self._by_place(self.unseen(height_m, by, k))

    def ground_m2(self) -> NDArray[np.float64]:
        """Return the area in m² of all ground that counts, by sector and band (8, bands)."""
        return self._by_place(self.ground.counts)

    def _by_place(self, flags: Flags) -> NDArray[np.float64]:
        bands = len(self.settings.bands_m) - 1
        place = self.ground.sector[flags].astype(np.int64) * bands + self.ground.band[flags]
        columns = np.bincount(place, minlength=len(SECTORS) * bands).reshape(-1, bands)
        return np.asarray(columns * self.column_m2, np.float64)

    def largest_hole(self, height_m: float, by: By = "any", k: int = 1) -> Hole | None:
        """Return the largest patch on which an object of that height is unseen, connected by sides; None without
        any."""
        labels, count = ndimage.label(self.unseen(height_m, by, k))
        if not count:
            return None
        sizes = np.bincount(labels.ravel())[1:]
        ix, iy = np.nonzero(labels == int(np.argmax(sizes)) + 1)
        ground = self.ground
        return Hole(
            float(sizes.max() * self.column_m2),
            float(ground.x_m[ix].mean()),
            float(ground.y_m[iy].mean()),
            float(ground.distance_m[ix, iy].min()),
        )


def share_seen(found: BlindMap, by: By = "any", k: int = 1) -> float:
    """Return the share of the ground within 10 m of the car on which an object of the least height is seen; more is
    better."""
    near = found.ground.counts & (found.ground.distance_m <= SHARE_WITHIN_M)
    unseen = found.unseen(HEIGHTS_M[0], by, k) & near
    return 1.0 - float(unseen.sum()) / max(1, int(near.sum()))


def overlap(found: BlindMap) -> NDArray[np.uint8]:
    """Count the sensors (nx, ny) that see an object of OVERLAP_HEIGHT_M in each column, 3 for more."""
    counted = np.sum([found.lowest_m("any", k) <= OVERLAP_HEIGHT_M + _EPSILON_M for k in (1, 2, 3)], axis=0)
    return np.asarray(counted, np.uint8)


def seen_by(by: By, k: int) -> str:
    """Return the number and kind of sensors as text: "1 sensor", "2 LiDARs"."""
    return f"{k} {called(by, k != 1)}"


def called(by: By, are_several: bool = False) -> str:
    """Return the name of the sensors that count."""
    kind = kind_named(by)
    one, several = ("sensor", "sensors") if kind is None else (kind.title, kind.plural)
    return several if are_several else one


def unseen_by(by: By, k: int) -> str:
    """Describe an object that fewer than k of them see: "unseen by any sensor", "seen by fewer than 2 LiDARs"."""
    return f"unseen by any {called(by)}" if k == 1 else f"seen by fewer than {seen_by(by, k)}"


_Look = tuple[Sensor, Obstacle | None]
"""A sensor, and what stops its rays."""


class _Row(NamedTuple):
    """A look, and the row that holds its levels."""

    look: _Look
    row: int


class BlindEngine:
    """Compute the blind zones of rigs on one vehicle; only changed sensors are computed again.

    Of each sensor the lowest levels around columns are kept, uint16 (rows, nx, ny), and no voxels. Call it from the
    thread that owns the parallel kernels."""

    def __init__(self, vehicle: Vehicle, settings: BlindSettings, threads: int | None = None) -> None:
        self.settings, self._workers = settings, jit.use_threads(threads)
        outline = Outline.of(vehicle)
        self.grid = grid_around(outline, settings)
        self.ground = Ground.of(self.grid, outline, settings.bands_m)
        self._field = whole_field(self.grid)
        self._caster = Caster(self._field, self._workers)
        self._marks = empty_words(self.grid)
        self._offsets = _disc(settings.width_m / settings.voxel_m / 2.0)
        self._around: Levels = np.empty((0, *self.grid.shape[:2]), np.uint16)
        self._rows: dict[str, _Row] = {}

    def evaluate(self, rig: Rig, failed: Collection[str] = (), stance: Pose = Pose()) -> BlindMap:
        """Return the lowest levels that the rig's enabled sensors see around the car, without those that have failed.

        stance: of the car, where the rig's poses are those of a car that stands otherwise than on level ground."""
        jit.use_threads(self._workers)
        sensors = [sensor.finest() for sensor in rig.sensors if sensor.enabled]
        solid = car_of(rig, stance) if self.settings.body == "blocks" else None
        self._look({one.name: (one, None if solid is None else obstacle_of(one, solid)) for one in sensors})
        counted = [sensor for sensor in sensors if sensor.name not in failed]
        rows = np.array([self._rows[sensor.name].row for sensor in counted], np.int64)
        groups = ("any", *sorted({sensor.kind for sensor in counted}))
        kinds = np.array([groups.index(sensor.kind) - 1 for sensor in counted], np.int64)
        levels = np.empty((len(groups), kernel.MOST_COUNTED, *self.grid.shape[:2]), np.uint16)
        kernel.three_lowest(self._around, rows, kinds, NONE, self._workers, levels)
        return BlindMap(rig, self.settings, self.grid, self.ground, groups, levels)

    def _look(self, looks: Mapping[str, _Look]) -> None:
        """Make these looks, by the sensors' names, the ones that are kept: cast the new ones."""
        self._rows = {name: one for name, one in self._rows.items() if looks.get(name) == one.look}
        if len(self._around) < len(looks):
            more = np.empty((len(looks) - len(self._around), *self.grid.shape[:2]), np.uint16)
            self._around = np.concatenate([self._around, more])
        free = iter(set(range(len(self._around))) - {one.row for one in self._rows.values()})
        for name, look in looks.items():
            if name not in self._rows:
                row = next(free)
                self._cast(*look, self._around[row])
                self._rows[name] = _Row(look, row)

    def _cast(self, sensor: Sensor, stop: Obstacle | None, around: Levels) -> None:
        """Cast a sensor, and write its lowest levels around columns (nx, ny)."""
        barrier = None if stop is None else stop.barrier
        self._marks[:] = 0
        self._caster.mark(sensor, "exact", self._caster.window(sensor), self._marks, barrier=barrier)
        lowest: Levels = np.empty(self.grid.shape[:2], np.uint16)
        keep, depth = self._field.index.words, words_per_column(self.grid)
        kernel.lowest_levels(self._marks, keep, depth, NONE, self._workers, lowest.ravel())
        kernel.lowest_around(lowest, self._offsets, NONE, self._workers, around)


def _disc(radius: float) -> NDArray[np.int64]:
    """Return the steps (m, 2) to the columns whose centres are within a radius, in columns, of a column's centre."""
    reach = np.arange(-math.floor(radius), math.floor(radius) + 1)
    x, y = np.meshgrid(reach, reach, indexing="ij")
    inside = np.hypot(x, y) <= radius + 1e-9
    return np.stack([x[inside], y[inside]], axis=1).astype(np.int64)
