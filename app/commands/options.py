"""Arguments that several commands share: the scene, the score, libraries; and how words become values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Group, Parameter, Token

from riglens.app.evaluation.options import DEFAULT_TOLERANCE_PP, AutoVoxel, SceneOptions, ScoreOptions, Triple
from riglens.core.errors import InputError

SCENE = Group("Scene: boxes and grid", sort_key=10)
SCORE = Group("Score", sort_key=20)
BODY = Parameter(name="--body", group=SCORE, metavar="NAME", show_default=False)
SolidBody = Annotated[Literal["ignored", "blocks"] | None, Parameter(name="--body", show=False)]
"""Where the car is always solid: `blocks` is taken, `ignored` refused (`require_solid`)."""
MAX_DIGITS = 40
BUILD = Group("Build", sort_key=30)


def whole_number(_: Any, tokens: Sequence[Token]) -> int:
    """A whole number as written; 1.5 is not rounded."""
    found = tokens[0].value
    digits = found.strip().lstrip("+-")
    if not digits.isdecimal() or len(digits) > MAX_DIGITS:
        shown = found if len(found) <= MAX_DIGITS else f"{found[:MAX_DIGITS]}…"
        raise ValueError(f"found {shown}, accepted is a whole number")
    return int(found)


def _edge_or_auto(_: Any, tokens: Sequence[Token]) -> float | str:
    """A voxel edge in metres, or the word auto."""
    found = tokens[0].value
    if found == "auto":
        return found
    try:
        return float(found)
    except ValueError:
        raise ValueError(f"found {found}, accepted is an edge in metres, or auto") from None


Rig = Annotated[str, Parameter(name="RIG")]
Out = Annotated[Path, Parameter(metavar="FILE")]
Whole = Annotated[int | None, Parameter(converter=whole_number, metavar="N")]


def _scene(name: str, metavar: str, converter: Callable[..., Any] | None = None) -> Parameter:
    return Parameter(
        name=name,
        group=SCENE,
        metavar=metavar,
        show_default=False,
        show_choices=converter is None,
        converter=converter,
    )


@Parameter(name="*")
@dataclass(frozen=True)
class BoxArguments:
    """How boxes are read, the same for every command that reads boxes."""

    origin: Annotated[Triple | None, _scene("--origin", "X Y Z")] = None
    """Where the origin of the data set lies in the vehicle frame, metres (nuScenes ego: -1.35 0 0)."""
    frames: Annotated[Whole, _scene("--frames", "N")] = None
    """Number of frames of the data set, where frames without boxes have no row."""
    classes: Annotated[tuple[str, ...], _scene("--classes", "NAME=CLASS")] = ()
    """Count boxes called NAME as car, bicycle or pedestrian, or ignore them; may be given many times."""
    ground: Annotated[Literal["auto"] | None, _scene("--ground", "auto")] = None
    """With auto, estimate the ground by the bottoms of near boxes and put it at z = 0; see `riglens data`."""


@Parameter(name="*")
@dataclass(frozen=True)
class ReadingArguments:
    """How boxes are read and cut into voxels."""

    how: BoxArguments = BoxArguments()
    voxel: Annotated[float | Literal["auto"] | None, _scene("--voxel", "M|auto", _edge_or_auto)] = None
    """Edge of a voxel in metres (0.1). With auto, where rigs are scored: the coarsest that suits them."""
    roi: Annotated[Triple | None, _scene("--roi", "L W H")] = None
    """Region of interest in metres: x in [-L/2, L/2), y in [-W/2, W/2), z in [0, H) (60 40 4)."""

    def options(
        self, boxes: Path | None, pog: Path | None = None, tolerance_pp: float | None = None
    ) -> SceneOptions:
        """Return the same as checked options, together with the data they are about."""
        auto, voxel_m = None, self.voxel
        if voxel_m == "auto":
            auto, voxel_m = AutoVoxel(DEFAULT_TOLERANCE_PP if tolerance_pp is None else tolerance_pp), None
        elif tolerance_pp is not None:
            raise InputError(
                f"--tolerance {tolerance_pp:g} belongs to --voxel auto; add that, or leave it out"
            )
        how, ground = self.how, self.how.ground == "auto"
        return SceneOptions(boxes, how.origin, how.frames, how.classes, voxel_m, self.roi, pog, auto, ground)


@Parameter(name="*")
@dataclass(frozen=True)
class SceneArguments:
    """The scene that rigs are scored on."""

    boxes: Annotated[Path | None, _scene("--boxes", "PATH")] = None
    """Box data set: table, nuScenes, Argoverse 2, KITTI or CARLA folder. Without it: the bundled scenario."""
    reading: ReadingArguments = ReadingArguments()
    pog: Annotated[Path | None, _scene("--pog", "FILE")] = None
    """Use a stored POG (made by `riglens pog`) instead of boxes."""
    tolerance: Annotated[float | None, _scene("--tolerance", "PP")] = None
    """What --voxel auto may change: percentage points of the entropy that is seen (1)."""

    def options(self) -> SceneOptions:
        """Return the same as checked options."""
        return self.reading.options(self.boxes, self.pog, self.tolerance)


@Parameter(name="*")
@dataclass(frozen=True)
class ScoreArguments:
    """Options about the metric."""

    method: Annotated[Literal["exact", "bresenham"], Parameter(group=SCORE, metavar="NAME")] = "exact"
    """How rays visit voxels."""
    reading: Annotated[Literal["covered", "residual", "hits"], Parameter(group=SCORE, metavar="NAME")] = (
        "covered"
    )
    """How S-MIG is read; see docs/metric.md."""
    camera_weight: Annotated[float, Parameter(name="--lambda", group=SCORE, metavar="X")] = 0.1
    """Weight of the cameras in S-MS."""
    threads: Annotated[Whole, Parameter(group=SCORE)] = None
    """Threads to use (all cores). The scores do not depend on it."""
    body: Annotated[Literal["ignored", "blocks"] | None, BODY] = None
    """Whether rays pass through the cars' own bodies or end at them, for this run (as each rig says)."""

    def options(self) -> ScoreOptions:
        """Return the same as checked options."""
        return ScoreOptions(self.method, self.reading, self.camera_weight, self.threads, self.body)


@Parameter(name="*")
@dataclass(frozen=True)
class LibraryArguments:
    """Sensor models beside those that ship with the program."""

    library: Annotated[tuple[Path, ...], Parameter(name="--library", metavar="FILE", show_default=False)] = ()
    """A file with sensor models of your own, for rigs that name them; may be given many times."""

    def use(self) -> None:
        """Let rigs use the models of these files."""
        if self.library:
            from riglens.core.rig.library import use_libraries

            use_libraries(self.library)


def check_json(target: str | None) -> None:
    """Refuse a file name that is more likely a misspelt option."""
    if target is not None and target.startswith("-") and target != "-":
        raise InputError(f"--json: found '{target}', accepted is a file name, or - for standard output")
