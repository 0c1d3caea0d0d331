"""Small scenes for the tests of the core: fields with chosen informative voxels, boxes, sensors, covers."""

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.caster import Caster
from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.kernels.rays.cast import mark_rays
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Method, MetricSettings
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig, Sensor
from riglens.core.scene.boxes import CLASSES, BoxBatch, DataReport, Progress
from riglens.core.scene.columns import VoxelIndex, pack, unpack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.scene.statistics import BoxTally

Mask = NDArray[np.bool_]
Numbers = Sequence[float] | NDArray[np.float64]


def grid_of(nx: int, ny: int, nz: int, voxel_m: float = 1.0) -> VoxelGrid:
    """A grid of nx x ny x nz voxels."""
    return VoxelGrid(voxel_m, (nx * voxel_m, ny * voxel_m, nz * voxel_m))


def synthetic_pog(grid: VoxelGrid, counts: NDArray[np.integer], frames: int) -> Pog:
    """A POG with given counts (nx, ny, nz, 3) of occupied frames."""
    occupied: Mask = np.any(counts, axis=-1)
    index = VoxelIndex.of(grid, pack(grid, occupied))
    i, j, k = index.ijk().T
    data = DataReport("synthetic", frames, dict.fromkeys(CLASSES, 1))
    dtype = np.uint16 if frames <= 65535 else np.uint32
    return Pog.of(grid, data, index, counts[i, j, k].astype(dtype))


def field_of(grid: VoxelGrid, informative: Mask | None = None) -> EntropyField:
    """A field in which the given voxels (default: all) are informative, with h = ln 2 for every class."""
    mask = np.ones(grid.shape, np.bool_) if informative is None else informative
    return EntropyField.from_pog(
        synthetic_pog(grid, np.repeat(mask[..., None], 3, axis=-1).astype(np.int64), 2)
    )


def random_field(
    grid: VoxelGrid, rng: np.random.Generator, frames: int = 50, share: float = 0.5
) -> EntropyField:
    """A field with random counts, in which a share of the voxels is occupied per class."""
    counts = rng.integers(1, frames, (*grid.shape, 3)) * (rng.random((*grid.shape, 3)) < share)
    return EntropyField.from_pog(synthetic_pog(grid, counts, frames))


def dense_h(field: EntropyField) -> NDArray[np.int64]:
    """Entropies in units of 2^-32 nat for every voxel of the grid, (nx, ny, nz, 3)."""
    h = np.zeros((*field.grid.shape, 3), np.int64)
    i, j, k = field.index.ijk().T
    h[i, j, k] = field.entropies_q[field.codes(), :3]
    return h


def evaluate(
    field: EntropyField, rig: Rig, settings: MetricSettings | None = None, threads: int | None = 1
) -> Evaluation:
    """Scores of a rig from scratch; by one thread, which is soonest done with the small scenes of tests."""
    return Engine(field, threads).evaluate(rig, settings or MetricSettings())


def rig_of(*sensors: Sensor) -> Rig:
    """A rig of these sensors; names are made unique."""
    return Rig(sensors=tuple(sensor.replace(name=f"S{i}") for i, sensor in enumerate(sensors)))


def seen_by(field: EntropyField, *sensors: Sensor, method: Method = "exact") -> Mask:
    """Informative voxels that the sensors traverse together, (nx, ny, nz)."""
    result = evaluate(field, rig_of(*sensors), MetricSettings(method=method))
    return unpack(field.grid, result.seen_by_any())


def seen_ray_by_ray(field: EntropyField, sensor: Sensor) -> Mask:
    """Informative voxels that a sensor traverses, found by the exact walk alone."""
    caster, marks = Caster(field), np.zeros_like(field.index.words)
    rays, spare = caster.rays(sensor, "exact"), np.zeros((0, marks.size), np.uint64)
    left = np.ones(len(rays.rows) * len(rays.planes), np.bool_)
    mark_rays(rays, 0, left.size, marks, spare, left)
    for word, bit in caster.walk_irregular(rays, np.flatnonzero(left)):
        marks[word] |= bit
    return unpack(field.grid, marks & field.index.words)


def triple(numbers: Numbers) -> tuple[float, float, float]:
    """Three numbers as plain floats."""
    x, y, z = map(float, numbers)
    return x, y, z


def lidar(
    position: Numbers = (0.0, 0.0, 0.0),
    rpy_deg: Numbers = (0.0, 0.0, 0.0),
    elevations: Numbers = (0.0,),
    azimuths: Numbers = (0.0,),
    range_m: tuple[float, float] = (0.0, float("inf")),
) -> Lidar:
    """A LiDAR with listed angles; a single ray straight ahead by default."""
    return Lidar(
        name="L",
        position=triple(position),
        rpy_deg=triple(rpy_deg),
        elevations_deg=tuple(map(float, elevations)),
        azimuths_deg=tuple(map(float, azimuths)),
        range_m=range_m,
    )


def spinning(position: Numbers, rpy_deg: Numbers = (0.0, 0.0, 0.0), beams: int = 4, count: int = 24) -> Lidar:
    """A LiDAR with `beams` over [-25, 25] degrees and a full turn."""
    return Lidar(
        name="L",
        position=triple(position),
        rpy_deg=triple(rpy_deg),
        elevations_deg=LinearAngles(from_=-25.0, to=25.0, count=beams),
        azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=count),
    )


def camera(
    position: Numbers,
    rpy_deg: Numbers = (0.0, 0.0, 0.0),
    cast: tuple[int, int] = (9, 7),
    hfov_deg: float = 70.0,
    range_m: tuple[float, float] = (0.0, float("inf")),
) -> Camera:
    """A camera with few rays."""
    return Camera(
        name="C",
        position=triple(position),
        rpy_deg=triple(rpy_deg),
        hfov_deg=hfov_deg,
        cast=cast,
        range_m=range_m,
    )


def random_sensor(grid: VoxelGrid, rng: np.random.Generator, rays: int = 30) -> Sensor:
    """A LiDAR or camera with generic numbers, in or around the ROI, looking anywhere."""
    roi = np.array(grid.roi_m)
    position = rng.uniform(-0.8, 0.8, 3) * roi + [0.0, 0.0, roi[2] / 2]
    rpy_deg = rng.uniform([-180.0, -90.0, -180.0], [180.0, 90.0, 180.0])
    near = float(rng.choice([0.0, rng.uniform(0.0, roi[0] / 2)]))
    range_m = (near, float(rng.choice([np.inf, near + rng.uniform(0.1, 1.0) * roi[0]])))
    if rng.random() < 0.5:
        columns = int(rng.integers(1, 8))
        return camera(
            position, rpy_deg, (columns, max(1, rays // columns)), float(rng.uniform(5.0, 170.0)), range_m
        )
    beams = int(rng.integers(1, 6))
    elevations = rng.uniform(-90.0, 90.0, beams)
    azimuths = rng.uniform(-180.0, 180.0, max(1, rays // beams))
    return lidar(position, rpy_deg, elevations, azimuths, range_m)


@dataclass(frozen=True)
class Boxes:
    """A box data set in memory; `frames` counts those without boxes too, `split` are batch borders."""

    frame: NDArray[np.int64]
    cls: NDArray[np.uint8]
    centre_m: NDArray[np.float64]
    size_m: NDArray[np.float64]
    rotation: NDArray[np.float64]
    frames: int
    split: tuple[int, ...] = ()
    name: str = "in memory"

    @property
    def content_hash(self) -> str:
        """Hash of everything that decides the POG."""
        digest = hashlib.sha256(str(self.frames).encode())
        for array in (self.frame, self.cls, self.centre_m, self.size_m, self.rotation):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()

    def batches(self, progress: Progress | None = None) -> Iterator[BoxBatch]:
        """The boxes, cut where the frame number passes a border."""
        part = np.searchsorted(np.array(self.split, np.int64), self.frame, side="right")
        for number in range(len(self.split) + 1):
            rows = part == number
            yield BoxBatch(
                self.frame[rows], self.cls[rows], self.centre_m[rows], self.size_m[rows], self.rotation[rows]
            )
            if progress is not None:
                progress((number + 1) / (len(self.split) + 1))

    def report(self) -> DataReport:
        """Frames and boxes per class."""
        boxes = {name: int((self.cls == c).sum()) for c, name in enumerate(CLASSES)}
        tally = BoxTally()
        tally.add(self.frame, self.cls, self.centre_m, self.size_m, self.rotation)
        return DataReport(
            self.name,
            self.frames,
            boxes,
            sha256=self.content_hash,
            statistics=tally.statistics((0.0, 0.0, 0.0)),
        )


def boxes_of(*rows: tuple[int, int, Sequence[float], Sequence[float], float], frames: int) -> Boxes:
    """Upright boxes from rows (frame, class, centre, size, yaw in radians)."""
    yaw = np.array([row[4] for row in rows])
    rotation = np.zeros((len(rows), 3, 3))
    rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(yaw)
    rotation[:, 1, 0] = np.sin(yaw)
    rotation[:, 0, 1] = -rotation[:, 1, 0]
    rotation[:, 2, 2] = 1.0
    return Boxes(
        np.array([row[0] for row in rows], np.int64),
        np.array([row[1] for row in rows], np.uint8),
        np.array([row[2] for row in rows], float).reshape(-1, 3),
        np.array([row[3] for row in rows], float).reshape(-1, 3),
        rotation,
        frames,
    )
