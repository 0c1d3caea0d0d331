"""Python interface, used as `import riglens as rl`: rigs, scenes, scores and pictures, with the code of the command
line.

Lengths are in metres, angles in degrees, entropies in nats. Coordinates are those of the vehicle frame: x forward,
y left, z up, origin on the ground under the centre of the body (ISO 8855). What a user can get wrong raises
`InputError`, whose message is one line; a `Rig`, `Lidar` or `Camera` with wrong values raises pydantic's
`ValidationError`. Both are `ValueError`s.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import remarks_on, settings_of
from riglens.app.evaluation.traffic import load_traffic as load_boxes
from riglens.arguments import RigLensWarning, StrPath, path_of
from riglens.core.errors import InputError
from riglens.core.files import require_apart
from riglens.core.formats.opening import open_rig as open_any_rig
from riglens.core.geometry import Pose, Vec3
from riglens.core.metric.scores import Body
from riglens.core.rig.model import Camera, EvenAngles, Lidar, Rig, Vehicle
from riglens.core.rig.presets import PRESETS
from riglens.core.rig.yaml.file import load_rig, new_rig_file
from riglens.core.scene.boxes import Progress
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import Phase, TargetSettings
from riglens.core.targets.shapes import Shape
from riglens.core.targets.traffic import WITHIN_M, Traffic
from riglens.optimising import OptimiseResult, optimise
from riglens.results import AuditResult, ClassResult, RigResult, TargetResult
from riglens.scenes import Scene, SceneEngine, audit, load_scene, score, with_blocking_mesh

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
    "OptimiseResult",
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
    "optimise",
    "presets",
    "render",
    "save_rig",
    "score",
    "targets",
]

ClassName = Literal["car", "bicycle", "pedestrian"]
# ---------------------------------------------------------------- rigs


def open_rig(name_or_path: StrPath) -> Rig:
    """Open a preset by its name ("W+T"), a rig file, or a rig in a foreign format, which is detected.

    Missing or unsupported parts of a foreign file raise a `RigLensWarning`. Raises InputError
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
    """Write a rig in a foreign format; return the rig that was written.

    `source` is a rig, or what `open_rig` takes. Formats go by the files unless they are named as for
    `riglens convert`. Approximated or omitted parts raise a `RigLensWarning`. Raises InputError when reading
    or writing fails.
    """
    from riglens.core.formats.exchange import write_rig  # many formats, which a preset does not need

    rig, report = _read(source, source_format)
    if not isinstance(source, Rig):
        require_apart(target, (source,))
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
    """Warn of lossy conversions, at the caller of the caller."""
    if report is not None:
        for remark in (*report.of_kind("approximated"), *report.of_kind("ignored")):
            text = f"{report.title}: {remark.kind}: {remark.sentence()}"
            warnings.warn(text, RigLensWarning, stacklevel=3)


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
    """Load the objects of a box data set, or of the bundled town, for use with `targets`.

    Those within `within_m` metres of the car count; all of them hide what is behind them, and so does, with
    `surroundings`, what stands in the bundled town, or for data of your own what `occluders` say: the table of it and
    that of the poses of the car. The other arguments are those
    of `load_scene`. Boxes that do not count raise a `RigLensWarning`. Raises InputError on bad data.
    """
    names = tuple(f"{name}={cls}" for name, cls in (classes or {}).items())
    options = SceneOptions(
        boxes=path_of(boxes),
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
    """Count the points and pixels of a rig on objects, including occlusion by traffic.

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
        LiDAR points from which a road user counts as detectable.
    sample
        Number of frames to use, drawn fairly; all by default.
    threads
        Threads to use, all processors by default. The counts do not depend on it.
    body
        Whether rays pass through the car's own body ("ignored", as in the paper) or end at it ("blocks"); as
        `rig.self_occlusion` says by default.
    mesh_folder
        The folder from which a car body in a mesh file is named; that of the rig file, as a rule.

    Raises InputError when a number is out of its range, or when the mesh of a body that blocks cannot be read.
    """
    options = ScoreOptions(threads=threads, body=body)
    settings = TargetSettings(shape, range_law, phase, seed, min_points, options.body_of(rig))
    if sample is not None and sample < 1:
        raise InputError(f"must be an integer ≥ 1 (got {sample})", "sample")
    rig = with_blocking_mesh(rig, options.body_of(rig), mesh_folder)
    return TargetResult(traffic, TargetEngine(traffic, threads).evaluate(rig, settings, sample))


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
    """Draw a rig, its rays and the heatmap of a class into a PNG file, without a display.

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
        be read is warned of, and a plain box replaces it.

    Raises InputError when a value is not accepted or the file cannot be written.
    """
    from riglens.app.launch.display import prepare_drawing
    from riglens.app.rendering.render import RenderRequest, as_drawn, drawn_score, score_and_draw
    from riglens.core.files import require_writable

    picture = RenderRequest(
        Path(out), view, size_px, scale, class_name, heatmap, transparent=transparent, title=title,
        scores=scores, theme=theme, baseline=baseline.name if baseline else None,
    )  # fmt: skip
    require_writable(out)
    prepare_drawing()
    rig = as_drawn(rig, Path(mesh_folder), lambda line: warnings.warn(line, RigLensWarning, stacklevel=4))
    settings = settings_of(drawn_score(rig, body))
    score_and_draw(rig, scene.pog, scene.field, picture, baseline, settings)
