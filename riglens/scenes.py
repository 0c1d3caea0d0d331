"""Scenes: the traffic around the car on a grid, scores of rigs in it, where their rays go, and all of it as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from riglens.arguments import (
    BoxReading,
    ClassName,
    StrPath,
    reads_boxes,
    require_kind,
    scene_options,
    warn,
    warn_of_data,
)
from riglens.core.engine.audit import audit as audit_rig
from riglens.core.engine.engine import Engine
from riglens.core.figures.evaluated import Evaluated, EvaluationSettings
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import DEFAULT_LAMBDA, Body, Method, Reading
from riglens.core.rig.body_mesh import BodyMesh
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES, DataReport, Progress
from riglens.core.scene.columns import unpack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.mesh_file import with_mesh_read
from riglens.evaluation.options import ScoreOptions
from riglens.evaluation.scenario import load_scenario, settings_of
from riglens.jobs.evaluating import evaluated_rigs
from riglens.results import AuditResult, RigResult

if TYPE_CHECKING:
    from riglens.core.sensing.rays import Rays
    from riglens.core.sensors.base import Sensor


@dataclass(frozen=True, eq=False)
class Scene:
    """Traffic around the car, ready to be scored on: made by `load_scene`, never changed.

    `pog` holds how often each voxel is occupied (probability of occupancy grid), `field` its entropies. Arrays have the
    shape of the grid, (nx, ny, nz): voxel i along x lies at `grid.centres_m(0)[i]`.
    """

    pog: Pog
    field: EntropyField

    @property
    def grid(self) -> VoxelGrid:
        """The voxel grid: `voxel_m`, `roi_m`, `shape`, `origin_m`."""
        return self.field.grid

    @property
    def data(self) -> DataReport:
        """Report on the data: `source`, `frames`, `boxes` per class, `unmapped`, `sha256`, `notes`."""
        return self.field.data

    def __repr__(self) -> str:
        nx, ny, nz = self.grid.shape
        return (
            f"<Scene of {self.data.short_source}: {self.data.frames:,} frames, {nx} × {ny} × {nz} voxels of "
            f"{self.grid.voxel_m:g} m>"
        )

    def probability(self, class_name: ClassName) -> NDArray[np.float64]:
        """Return the probability that an object of a class occupies a voxel, (nx, ny, nz)."""
        found = np.zeros(self.grid.shape)
        found[unpack(self.grid, self.pog.index.words)] = self.pog.probability(CLASSES.index(class_name))
        return found

    def entropy(self, class_name: ClassName) -> NDArray[np.float64]:
        """Return the entropy of each voxel for a class in nat, (nx, ny, nz)."""
        found = np.zeros(self.grid.shape)
        found[unpack(self.grid, self.field.index.words)] = self.field.entropy_nat(CLASSES.index(class_name))
        return found

    def seen(
        self,
        rig: Rig,
        *,
        kind: str | None = None,
        sensor: str | None = None,
        method: Method = "exact",
        body: Body | None = None,
        threads: int | None = None,
        mesh_folder: StrPath = ".",
    ) -> NDArray[np.bool_]:
        """Return the informative voxels that a rig sees, all of it or one kind or one sensor, (nx, ny, nz)."""
        require_kind(kind)
        sensors = [one for one in rig.sensors if sensor in (None, one.name) and kind in (None, one.kind)]
        options = ScoreOptions(method, threads=threads, body=body)
        part = with_blocking_mesh(rig, options.body_of(rig), mesh_folder).model_copy(
            update={"sensors": tuple(sensors)}
        )
        found = Engine(self.field, threads).evaluate(part, settings_of(options))
        return unpack(self.grid, found.seen_by_any())

    def engine(self, threads: int | None = None) -> SceneEngine:
        """Return an engine for many rigs, which casts only what changes from one to the next; use it in a `with`."""
        return SceneEngine(self, threads)


@reads_boxes
def load_scene(
    boxes: StrPath | None = None,
    voxel_m: float | None = None,
    *,
    roi_m: ArrayLike | None = None,
    pog: StrPath | None = None,
    progress: Progress | None = None,
    **read_as: Unpack[BoxReading],
) -> Scene:
    """Load the traffic of a box data set, of a stored POG, or of the bundled town.

    POGs of box data are kept in the user's cache folder, so that the next call for the same data is quick. Boxes that
    do not count are reported as a `RigLensWarning`. Raises InputError on bad data or arguments that disagree.

    Parameters
    ----------
    boxes
        Table (CSV, Parquet), or folder (nuScenes, Argoverse 2, KITTI, CARLA); None for the bundled town.
    voxel_m
        Edge of a voxel in metres; 0.1 by default, or that of the stored POG.
    roi_m
        Length, width and height of the region of interest in metres; (60, 40, 4) by default.
    origin_m
        Where the origin of the data set lies in the vehicle frame, metres.
    frames
        Number of frames, if frames without boxes leave no trace in the data.
    classes
        Names in the data set and the class as which they count: "car", "bicycle", "pedestrian" or "ignore".
    find_ground
        Estimate the ground from the bottoms of near boxes and put it at z = 0.
    pog
        File made by `riglens data build`, in place of boxes.
    progress
        Called with the fraction done, 0 to 1, while a POG is built.
    """
    options = scene_options(boxes, voxel_m=voxel_m, roi_m=roi_m, pog=pog, **read_as)
    found = load_scenario(options, progress)
    warn_of_data(found.field.data)
    return Scene(found.pog, found.field)


# ---------------------------------------------------------------- scores


def score(
    rig: Rig,
    scene: Scene,
    traffic: Traffic | None = None,
    *,
    method: Method = "exact",
    reading: Reading = "covered",
    camera_weight: float = DEFAULT_LAMBDA,
    threads: int | None = None,
    body: Body | None = None,
    mesh_folder: StrPath = ".",
) -> RigResult:
    """Score a rig on a scene, from scratch; for many rigs use `scene.engine()`.

    Raises InputError when a number is out of its range, or when the mesh of a body that blocks cannot be read.

    Parameters
    ----------
    rig, scene
        What to score, and the traffic to score it on.
    traffic
        The same traffic as single objects, from `load_traffic`, for the figures of objects.
    method
        How rays visit voxels: "exact" or "bresenham".
    reading
        How S-MIG is read: "covered", "residual" or "hits"; see docs/metric.md.
    camera_weight
        Weight λ of the cameras in S-MS.
    threads
        Threads to use, all processors by default. The scores do not depend on it.
    body
        Whether rays pass through the car's own body ("ignored", as in the paper) or end at it ("blocks"); as
        `rig.self_occlusion` says by default.
    mesh_folder
        The folder from which a car body in a mesh file is named; that of the rig file, as a rule.
    """
    options = ScoreOptions(method, reading, camera_weight, threads, body)
    rig = with_blocking_mesh(rig, options.body_of(rig), mesh_folder)
    settings = EvaluationSettings(settings_of(options), TargetSettings(body=options.body))
    (evaluated,) = evaluated_rigs([rig], scene.field, traffic, settings, threads=threads)
    return RigResult(scene.pog, scene.field, evaluated)


def audit(
    rig: Rig,
    scene: Scene,
    *,
    body: Body = "blocks",
    threads: int | None = None,
    mesh_folder: StrPath = ".",
) -> AuditResult:
    """Return the ray outcomes of each enabled sensor: at the car, past the region, at the ground, in uncertain space.

    Arguments as for `score`; the car is always solid here (`body="blocks"`).
    """
    ScoreOptions(threads=threads).solid(body)
    rig = with_blocking_mesh(rig, "blocks", mesh_folder)
    return AuditResult(audit_rig(Engine(scene.field, threads), rig))


def with_blocking_mesh(rig: Rig, body: Body | None, folder: StrPath) -> Rig:
    """Return the rig with the mesh of a body that blocks, where a file holds it; warn of a size that is not a car's."""
    return with_mesh_read(rig, Path(folder), warn) if body == "blocks" else rig


def with_blocking_meshes(rigs: Rig | Sequence[Rig], score: ScoreOptions, folder: StrPath) -> list[Rig]:
    """Return a rig or several with their meshes, where these block."""
    listed = [rigs] if isinstance(rigs, Rig) else rigs
    return [with_blocking_mesh(rig, score.body_of(rig), folder) for rig in listed]


class ForManyRigs:
    """Context of an engine: leaving the `with` block closes it."""

    _engine: object

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._engine = None


class SceneEngine(ForManyRigs):
    """Engine that scores rigs one after the other and casts only the sensors that changed; the scores are those of
    `score`.

    Made by `scene.engine()`, for one thread. It holds the voxels of each sensor until the `with` block ends.
    """

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        ScoreOptions(threads=threads)
        self._scene = scene
        self._engine: Engine | None = Engine(scene.field, threads)
        self._meshes: dict[tuple[str, Path], BodyMesh] = {}

    def evaluate(
        self,
        rig: Rig,
        *,
        method: Method = "exact",
        reading: Reading = "covered",
        camera_weight: float = DEFAULT_LAMBDA,
        body: Body | None = None,
        mesh_folder: StrPath = ".",
    ) -> RigResult:
        """Score a rig; arguments as for `score`. Raises RuntimeError after the `with` block."""
        if self._engine is None:
            raise RuntimeError("this engine was closed at the end of its with block")
        options = ScoreOptions(method, reading, camera_weight, None, body)
        place = (rig.vehicle.body, Path(mesh_folder))
        if place in self._meshes:
            rig = rig.with_body_mesh(self._meshes[place])
        else:
            rig = with_blocking_mesh(rig, options.body_of(rig), mesh_folder)
            if rig.vehicle.body_mesh is not None:
                self._meshes[place] = rig.vehicle.body_mesh
        settings = EvaluationSettings(settings_of(options))
        found = self._engine.evaluate(rig, settings.metric, with_seen=False)
        evaluated = Evaluated(rig, settings, self._scene.field, found)
        return RigResult(self._scene.pog, self._scene.field, evaluated)


# ---------------------------------------------------------------- rays and the car's body


def rays(sensor: Sensor) -> Rays:
    """Return the rays of a sensor in the vehicle frame: `origin_m`, unit `directions` (n, 3), `range_m`."""
    from riglens.core.sensing.rays import sensor_rays

    return sensor_rays(sensor)


def body_triangles(rig: Rig, mesh_folder: StrPath = ".") -> NDArray[np.float64]:
    """Return the triangles of the car's body in the vehicle frame, (t, 3, 3) metres: corners by triangle."""
    from riglens.core.vehicle.solid import solid_of

    return solid_of(with_blocking_mesh(rig, "blocks", mesh_folder).vehicle).triangles_m
