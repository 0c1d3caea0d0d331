"""What scripts use, as `import riglens as rl`: rigs, scenes, scores and pictures, with the code of the command line.

Lengths are in metres, angles in degrees, entropies in nats. Coordinates are those of the vehicle frame: x forward,
y left, z up, origin on the ground under the centre of the body (ISO 8855). What a user can get wrong raises
`InputError`, whose message is one line; a `Rig`, `Lidar` or `Camera` with wrong values raises pydantic's
`ValidationError`. Both are `ValueError`s.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Literal, Self

from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import load_scenario, remarks_on, settings_of
from riglens.app.evaluation.traffic import load_traffic as load_boxes
from riglens.core.engine.audit import audit as audit_rig
from riglens.core.engine.engine import Engine, evaluate_from_scratch
from riglens.core.errors import InputError
from riglens.core.files import require_apart
from riglens.core.formats.opening import open_rig as open_any_rig
from riglens.core.geometry import Pose, Vec3
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import DEFAULT_LAMBDA, Body, Method, Reading
from riglens.core.rig.model import Camera, EvenAngles, Lidar, Rig, Vehicle
from riglens.core.rig.presets import PRESETS
from riglens.core.rig.yaml.file import load_rig, new_rig_file
from riglens.core.scene.boxes import DataReport, Progress
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import Phase, TargetSettings
from riglens.core.targets.shapes import Shape
from riglens.core.targets.traffic import WITHIN_M, Traffic
from riglens.core.vehicle.mesh import BodyMesh
from riglens.core.vehicle.mesh_file import mesh_path, read_mesh
from riglens.results import AuditResult, ClassResult, RigResult, TargetResult

if TYPE_CHECKING:
    from riglens.app.evaluation.options import HeatMode
    from riglens.app.rendering.render import Theme, View
    from riglens.core.formats.report import Report

__all__ = [
    "AuditResult",
    "Camera",
    "ClassResult",
    "EvenAngles",
    "InputError",
    "Lidar",
    "Pose",
    "Rig",
    "RigLensWarning",
    "RigResult",
    "Scene",
    "SceneEngine",
    "TargetResult",
    "Traffic",
    "Vehicle",
    "audit",
    "convert",
    "load_scene",
    "load_traffic",
    "open_rig",
    "presets",
    "render",
    "save_rig",
    "score",
    "targets",
]

StrPath = str | os.PathLike[str]
ClassName = Literal["car", "bicycle", "pedestrian"]
_ARGUMENTS = {
    "--ground auto": "find_ground",
    "--boxes": "boxes",
    "--voxel": "voxel_m",
    "--roi": "roi_m",
    "--origin": "origin_m",
    "--frames": "frames",
    "--classes": "classes",
    "--ground": "find_ground",
    "--pog": "pog",
    "--lambda": "camera_weight",
    "--threads": "threads",
    "--to": "target_format",
    "--out": "out",
    "--size": "size_px",
    "--scale": "scale",
    "--heatmap": "heatmap",
    "--baseline": "baseline",
    "--within": "within_m",
    "--min-points": "min_points",
    "--sample": "sample",
    "--seed": "seed",
}
"""Options of the command line, which messages name, and the arguments here."""
_OPTION = re.compile("|".join(rf"(?<![^\s(])(?:{name})(?=$|[\s:,;?)]|\.(?:\s|$))" for name in _ARGUMENTS))
"""An option as a word of its own, not as a piece of a path such as /data/--out/a.csv."""


class RigLensWarning(UserWarning):
    """Something to know about data or a rig that were read: what does not count, was approximated or left out."""


# ---------------------------------------------------------------- rigs


def open_rig(name_or_path: StrPath) -> Rig:
    """Open a preset by its name ("W+T"), a rig file, or a rig in another program's format, which is detected.

    What another program's file leaves open or RigLens cannot say is told as a `RigLensWarning`. Raises InputError
    when there is no such preset or file, or when the file is wrong.
    """
    rig, report = _read(name_or_path, None)
    _warn_of_losses(report)
    return rig


def presets() -> tuple[str, ...]:
    """List the names of the built-in rigs."""
    return tuple(PRESETS)


def save_rig(rig: Rig, path: StrPath) -> None:
    """Write a rig file (YAML) that reads back to the same rig, bit for bit.

    Comments and layout of a rig file that is there already are kept. Raises InputError when the rig is not valid or
    the file cannot be written; an old file stays as it was then.
    """
    try:
        file = load_rig(path)
    except InputError:
        file = new_rig_file(rig)
    file.save(path, rig)


def convert(
    source: StrPath | Rig,
    target: StrPath,
    *,
    source_format: str | None = None,
    target_format: str | None = None,
) -> Rig:
    """Write a rig in another program's format; returns the rig that was written.

    `source` is a rig, or what `open_rig` takes. Formats go by the files unless they are named as for
    `riglens convert`. What is approximated or left out is told as a `RigLensWarning`. Raises InputError when reading
    or writing fails.
    """
    from riglens.core.formats.exchange import write_rig  # many formats, which a preset does not need

    rig, report = _read(source, source_format)
    if not isinstance(source, Rig):
        require_apart(target, (source,))
    with _argument_names(target):
        exported = write_rig(rig, target, target_format)
    _warn_of_losses(report)
    _warn_of_losses(exported.report)
    return rig


def _read(source: StrPath | Rig, source_format: str | None) -> tuple[Rig, Report | None]:
    """A rig that may have to be read, and what became of it then."""
    if isinstance(source, Rig):
        return source, None
    if source_format is not None:
        from riglens.core.formats.exchange import read_rig

        imported = read_rig(source, source_format)
        return imported.rig, imported.report
    opened = open_any_rig(os.fspath(source))
    return opened.rig, opened.report


def _warn_of_losses(report: Report | None) -> None:
    """Warn of what was not taken over as it stood, at the caller of the caller."""
    if report is not None:
        for remark in (*report.of_kind("approximated"), *report.of_kind("ignored")):
            text = f"{report.title}: {remark.kind}: {remark.sentence()}"
            warnings.warn(text, RigLensWarning, stacklevel=3)


# ---------------------------------------------------------------- scenes


@dataclass(frozen=True)
class Scene:
    """Traffic around the car, ready to be scored on: made by `load_scene`, never changed.

    `pog` holds how often each voxel is occupied (probability of occupancy grid), `field` its entropies.
    """

    pog: Pog
    field: EntropyField

    @property
    def grid(self) -> VoxelGrid:
        """The voxel grid: `voxel_m`, `roi_m`, `shape`, `origin_m`."""
        return self.field.grid

    @property
    def data(self) -> DataReport:
        """What the data held: `source`, `frames`, `boxes` per class, `unmapped`, `sha256`, `notes`."""
        return self.field.data

    def engine(self, threads: int | None = None) -> SceneEngine:
        """An engine for many rigs, which casts only what changes from one to the next; use it in a `with` block."""
        return SceneEngine(self, threads)


def load_scene(
    boxes: StrPath | None = None,
    voxel_m: float | None = None,
    *,
    roi_m: Vec3 | None = None,
    origin_m: Vec3 | None = None,
    frames: int | None = None,
    classes: Mapping[str, str] | None = None,
    find_ground: bool = False,
    pog: StrPath | None = None,
    progress: Progress | None = None,
) -> Scene:
    """Load the traffic of a box data set, of a stored POG, or of the bundled town.

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
        Number of frames, where frames without boxes have no row.
    classes
        Names in the data set and the class as which they count: "car", "bicycle", "pedestrian" or "ignore".
    find_ground
        Estimate the ground from the bottoms of near boxes and put it at z = 0.
    pog
        File made by `riglens pog`, in place of boxes.
    progress
        Called with the fraction done, 0 to 1, while a POG is built.

    POGs of box data are kept in the user's cache folder, so that the next call for the same data is quick. Boxes that
    do not count are told as a `RigLensWarning`. Raises InputError on bad data or arguments that disagree.
    """
    with _argument_names(boxes, pog, *(classes or {})):
        options = SceneOptions(
            boxes=_path(boxes),
            origin_m=origin_m,
            frames=frames,
            classes=tuple(f"{name}={cls}" for name, cls in (classes or {}).items()),
            voxel_m=voxel_m,
            roi_m=roi_m,
            pog=_path(pog),
            find_ground=find_ground,
        )
        found = load_scenario(options, progress)
    for line in remarks_on(found.field.data):
        warnings.warn(line, RigLensWarning, stacklevel=2)
    return Scene(found.pog, found.field)


def _path(path: StrPath | None) -> Path | None:
    return None if path is None else Path(path)


# ---------------------------------------------------------------- scores


def score(
    rig: Rig,
    scene: Scene,
    *,
    method: Method = "exact",
    reading: Reading = "covered",
    camera_weight: float = DEFAULT_LAMBDA,
    threads: int | None = None,
    body: Body | None = None,
    mesh_folder: StrPath = ".",
) -> RigResult:
    """Score a rig on a scene, from scratch; for many rigs use `scene.engine()`.

    Parameters
    ----------
    rig, scene
        What to score, and the traffic to score it on.
    method
        How rays visit voxels: "exact" or "bresenham".
    reading
        How S-MIG is read: "covered", "residual" or "hits"; see docs/metric.md.
    camera_weight
        Weight λ of the cameras in S-MS.
    threads
        Threads to use, all processors by default. The scores do not depend on it.
    body
        Whether rays pass through the car's own body ("ignored", as in the paper) or end at it ("blocks"). By default
        the built-in rigs are scored as in the paper, and others with the car solid.
    mesh_folder
        The folder from which a car body in a mesh file is named; that of the rig file, as a rule.

    Raises InputError when a number is out of its range, or when the mesh of a body that blocks cannot be read.
    """
    with _argument_names():
        options = ScoreOptions(method, reading, camera_weight, threads, body).for_rigs([rig])
    mesh = _mesh_of(rig, options, mesh_folder)
    (found,) = evaluate_from_scratch(scene.field, [rig], settings_of(options), threads, meshes=[mesh])
    return RigResult(scene.field, found)


def audit(
    rig: Rig,
    scene: Scene,
    *,
    body: Body = "blocks",
    threads: int | None = None,
    mesh_folder: StrPath = ".",
) -> AuditResult:
    """Say where the rays of each enabled sensor go: into the car, past the region, to the ground, to something new.

    Parameters
    ----------
    rig, scene
        Whose rays to follow, and what is informative.
    body
        Whether rays end at the car's own body ("blocks") or pass through it ("ignored").
    threads
        Threads to use, all processors by default. The result does not depend on it.
    mesh_folder
        The folder from which a car body in a mesh file is named; that of the rig file, as a rule.

    Raises InputError when a number is out of its range, or when the mesh of the body cannot be read.
    """
    with _argument_names():
        ScoreOptions(threads=threads, body=body)
    mesh = read_mesh(mesh_path(rig.vehicle.body, Path(mesh_folder))) if rig.vehicle.has_mesh_file else None
    return AuditResult(audit_rig(scene.field, rig, body, mesh, threads))


def _mesh_of(rig: Rig, options: ScoreOptions, folder: StrPath) -> BodyMesh | None:
    """The mesh of a body that blocks, where a file holds it."""
    if options.body != "blocks" or not rig.vehicle.has_mesh_file:
        return None
    return read_mesh(mesh_path(rig.vehicle.body, Path(folder)))


class SceneEngine:
    """Scores rigs one after the other and casts only the sensors that changed; the scores are those of `score`.

    Made by `scene.engine()`, for one thread. It holds the voxels of each sensor until the `with` block ends.
    """

    def __init__(self, scene: Scene, threads: int | None = None) -> None:
        with _argument_names():
            ScoreOptions(threads=threads)
        self._engine: Engine | None = Engine(scene.field, threads)
        self._meshes: dict[tuple[str, Path], BodyMesh] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._engine = None

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
        with _argument_names():
            options = ScoreOptions(method, reading, camera_weight, None, body).for_rigs([rig])
        vehicle, folder = rig.vehicle, Path(mesh_folder)
        if options.body == "blocks" and vehicle.has_mesh_file and (vehicle.body, folder) not in self._meshes:
            self._meshes[vehicle.body, folder] = read_mesh(mesh_path(vehicle.body, folder))
        mesh = self._meshes.get((vehicle.body, folder))
        found = self._engine.evaluate(rig, settings_of(options), with_seen=False, mesh=mesh)
        return RigResult(self._engine.field, found)


# ---------------------------------------------------------------- points and pixels on road users


def load_traffic(
    boxes: StrPath | None = None,
    *,
    within_m: float = WITHIN_M,
    origin_m: Vec3 | None = None,
    frames: int | None = None,
    classes: Mapping[str, str] | None = None,
    find_ground: bool = False,
    surroundings: bool = False,
    occluders: tuple[StrPath, StrPath] | None = None,
    progress: Progress | None = None,
) -> Traffic:
    """Load the road users of a box data set, or of the bundled town, to count on with `targets`.

    Those within `within_m` metres of the car count; all of them hide what is behind them, and so does, with
    `surroundings`, what stands in the bundled town, or for data of your own what `occluders` say: the table of it and
    that of the poses of the car. The other arguments are those
    of `load_scene`. Boxes that do not count are told as a `RigLensWarning`. Raises InputError on bad data.
    """
    with _argument_names():
        names = tuple(f"{name}={cls}" for name, cls in (classes or {}).items())
        options = SceneOptions(
            boxes=_path(boxes),
            origin_m=origin_m,
            frames=frames,
            classes=names,
            find_ground=find_ground,
            surroundings=surroundings or occluders is not None,
            occluders=None if occluders is None else (Path(occluders[0]), Path(occluders[1])),
        )
        found = load_boxes(options, within_m, progress)
    for line in remarks_on(found.data):
        warnings.warn(line, RigLensWarning, stacklevel=2)
    return found


def targets(
    rig: Rig,
    traffic: Traffic,
    *,
    shape: Shape = "class",
    range_law: bool = True,
    phase: Phase = "random",
    seed: int = 0,
    min_points: int = 5,
    sample: int | None = None,
    threads: int | None = None,
    body: Body | None = None,
    mesh_folder: StrPath = ".",
) -> TargetResult:
    """Count the points and pixels that a rig gets onto road users, behind the traffic before them.

    Parameters
    ----------
    rig, traffic
        What to count for, and the road users: made by `load_traffic`.
    shape
        "class": cars have glass and a gap below, cyclists and pedestrians are slim; "box": plain boxes.
    range_law
        Whether rays of LiDARs that come from far, or meet a face at a slant, may get lost.
    phase, seed
        "random" turns each LiDAR in each frame by a part of its azimuth step, drawn by the seed; "0" does not.
    min_points
        A road user with so many LiDAR points counts as detectable.
    sample
        Number of frames to use, drawn fairly; all by default.
    threads
        Threads to use, all processors by default. The counts do not depend on it.
    body
        Whether rays pass through the car's own body ("ignored", as in the paper) or end at it ("blocks"). By default
        "ignored" for the built-in rigs of the paper and "blocks" for all others.
    mesh_folder
        The folder from which a car body in a mesh file is named; that of the rig file, as a rule.

    Raises InputError when a number is out of its range, or when the mesh of a body that blocks cannot be read.
    """
    with _argument_names():
        options = ScoreOptions(threads=threads, body=body).for_rigs([rig])
        settings = TargetSettings(shape, range_law, phase, seed, min_points, options.body or "ignored")
        if sample is not None and sample < 1:
            raise InputError(f"--sample: found {sample}, accepted is a whole number of frames from 1 up")
    mesh = _mesh_of(rig, options, mesh_folder)
    return TargetResult(traffic, TargetEngine(traffic, threads).evaluate(rig, settings, sample, mesh))


# ---------------------------------------------------------------- pictures


def render(
    rig: Rig,
    scene: Scene,
    out: StrPath,
    *,
    view: View = "iso",
    size_px: tuple[int, int] = (1280, 800),
    scale: int = 1,
    class_name: ClassName = "car",
    heatmap: HeatMode = "seen",
    baseline: Rig | None = None,
    theme: Theme = "dark",
    transparent: bool = False,
    title: bool = False,
    scores: bool = False,
    mesh_folder: StrPath = ".",
    body: Body | None = None,
) -> None:
    """Draw a rig, its rays and the heatmap of a class into a PNG file; it takes no display.

    Parameters
    ----------
    out
        The picture (.png).
    view
        Where to look from: "iso", "top", "front", "left" or "rear".
    size_px, scale
        Width and height in pixels, and how many times as many pixels to draw along each side.
    class_name, heatmap
        What the heatmap shows: "probability", "entropy", "seen", "unseen", "sensors", "change" or "off".
    baseline
        The rig that `heatmap="change"` starts from.
    theme, transparent
        "dark" or "light"; no background at all.
    title, scores
        Write the rig's name, and the table of its scores, into the picture.
    mesh_folder
        The folder from which a car body in a mesh file is named; that of the rig file, as a rule. A mesh that cannot
        be read is warned of, and a plain box stands in for it.

    Raises InputError when a value is not accepted or the file cannot be written.
    """
    from riglens.app.launch.display import prepare_drawing
    from riglens.app.rendering.render import RenderRequest, body_of, drawn_score, score_and_draw
    from riglens.core.files import require_writable

    with _argument_names(out):
        picture = RenderRequest(
            Path(out), view, size_px, scale, class_name, heatmap, transparent=transparent, title=title,
            scores=scores, theme=theme, baseline=baseline.name if baseline else None,
        )  # fmt: skip
    require_writable(out)
    prepare_drawing()
    mesh = body_of(rig, Path(mesh_folder), lambda line: warnings.warn(line, RigLensWarning, stacklevel=4))
    settings = settings_of(drawn_score(rig, mesh, body))
    score_and_draw(rig, scene.pog, scene.field, picture, mesh, baseline, settings)


@contextmanager
def _argument_names(*given: object) -> Iterator[None]:
    """Have an InputError of the block name arguments where it names options of the command line.

    What the user has `given`, such as the name of a file, stays as it is.
    """
    try:
        yield
    except InputError as error:
        kept = sorted({str(value) for value in given if value is not None and "--" in str(value)}, key=len)
        named = re.compile("|".join([*map(re.escape, reversed(kept)), _OPTION.pattern]))
        text = named.sub(lambda found: found[0] if found[0] in kept else _ARGUMENTS[found[0]], str(error))
        raise InputError(text) from error
