"""Define the options of a scene and a score: plain data, cheap to import."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from riglens.core.errors import InputError
from riglens.core.metric.scores import MAX_LAMBDA, Body
from riglens.core.option_help import PHASE, RANGE_LAW, SHAPE, OptionHelp

if TYPE_CHECKING:  # the model of rigs takes its time, and `riglens --help` needs none
    from riglens.core.review.requirements import Settings
    from riglens.core.rig.model import Rig
    from riglens.core.targets.settings import TargetSettings

Triple = tuple[float, float, float]

DEFAULT_RIG = "nuScenes car"
"""The rig that the window starts on."""
PAPER_RIG = "W+T"
"""The rig of the paper's figures."""
DEFAULT_TOLERANCE_PP = 1.0
MOST_LETTERS = 200
"""In a word of the header of a report."""
MAX_THREADS = 1024
MIN_SIDE_PX, MAX_SIDE_PX, MAX_SCALE = 64, 8192, 4
"""Limits of a picture's sides before scaling, and of the scale."""


DASK = OptionHelp(
    "ADDRESS",
    "Work on the Dask cluster of this scheduler, such as tls://10.0.0.1:8786. Trusted "
    "clusters only: anyone with access can run code here (docs/security.md).",
)
REQUIREMENTS = OptionHelp("FILE", "File of requirements, as for `riglens check`.")
PROFILES = OptionHelp(
    "FILE", "File of your own blind zone profiles, instead of the bundled ones; may be repeated."
)
WORKERS = OptionHelp("N", "Processes that work at the same time (as many as cores and memory allow).")
LIBRARY = OptionHelp("FILE", "File with your own sensor models, for rigs that name them; may be repeated.")


@dataclass(frozen=True)
class ScoreOptions:
    """Options of the score; checked here so that a typing error costs no evaluation."""

    method: Annotated[Literal["exact", "bresenham"], OptionHelp("NAME", "How rays visit voxels.")] = "exact"
    reading: Annotated[
        Literal["covered", "residual", "hits"], OptionHelp("NAME", "Reading of S-MIG; see docs/metric.md.")
    ] = "covered"
    camera_weight: Annotated[float, OptionHelp("X", "Weight of the cameras in S-MS.")] = 0.1
    threads: Annotated[
        int | None, OptionHelp("N", "Number of threads (all cores). Figures do not depend on it.")
    ] = None
    body: Annotated[
        Body | None,
        OptionHelp("NAME", "Rays pass through the cars' own bodies or end at them (as set in each rig)."),
    ] = None
    """For all rigs in this run; None: as set in each rig."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.camera_weight <= MAX_LAMBDA:
            raise InputError(
                f"must be between 0 and {MAX_LAMBDA:,.0f} (got {self.camera_weight:g})", "camera_weight"
            )
        if self.threads is not None and not 1 <= self.threads <= MAX_THREADS:
            shown = f"{self.threads}" if abs(self.threads) < 1 << 64 else "a very large number"
            raise InputError(f"must be an integer from 1 to {MAX_THREADS} (got {shown})", "threads")

    def as_required(self, body: Body | None, where: Path) -> ScoreOptions:
        """Return the options with the body that a file of requirements demands; raise InputError if `body`
        contradicts."""
        if None not in (self.body, body) and self.body != body:
            raise InputError(f"must be {body}, as {where} requires (got {self.body})", "body")
        return replace(self, body=self.body or body)

    def solid(self, said: Body | None = None) -> ScoreOptions:
        """Return the options with solid cars; raise InputError if something else was given."""
        if said == "ignored":
            raise InputError("must be blocks (got ignored): here the car is always solid", "body")
        return replace(self, body="blocks")

    def body_of(self, rig: Rig) -> Body:
        """Return whether rays end at a rig's own body."""
        return self.body or rig.body


READING = ("origin_m", "frames", "classes", "find_ground")
"""Options of how boxes are read: of every command, study and function of Python that reads them."""
GRID = (*READING, "voxel_m", "roi_m")


@dataclass(frozen=True)
class SceneOptions:
    """Options of a scene: boxes and grid; None is the bundled scenario and the default grid.

    The one form of these options: commands show each field as an option (`app/commands/options.py`), the Python
    interface and the window make it. Numbers are checked where they are used: by grid and readers.
    """

    boxes: Annotated[
        Path | None,
        OptionHelp(
            "PATH",
            "Box data set: a table, or a folder of nuScenes, Argoverse 2, KITTI, ONCE, ZOD, DAIR-V2X, OPV2V or CARLA. "
            "Without it: the bundled scenario.",
        ),
    ] = None
    origin_m: Annotated[
        Triple | None,
        OptionHelp(
            "X Y Z",
            "Origin of the data set in the vehicle frame, metres (nuScenes ego: -1.35 0 0).",
        ),
    ] = None
    frames: Annotated[
        int | None,
        OptionHelp("N", "Number of frames of the data set, if frames without boxes leave no trace in it."),
    ] = None
    classes: Annotated[
        tuple[str, ...],
        OptionHelp(
            "NAME=CLASS",
            "Count boxes called NAME as car, bicycle or pedestrian, or ignore them; may be repeated.",
        ),
    ] = ()
    find_ground: Annotated[
        bool,
        OptionHelp(
            "auto",
            "With auto, put the ground, estimated from the bottoms of near boxes, at z = 0; see `riglens data show`.",
        ),
    ] = False
    voxel_m: Annotated[
        float | Literal["auto"] | None,
        OptionHelp(
            "M|auto",
            "Edge of a voxel in metres (0.1). auto: the coarsest suitable edge, where rigs are scored.",
        ),
    ] = None
    roi_m: Annotated[
        Triple | None,
        OptionHelp(
            "L W H",
            "Region of interest in metres: x in [-L/2, L/2), y in [-W/2, W/2), z in [0, H) (60 40 4).",
        ),
    ] = None
    pog: Annotated[
        Path | None, OptionHelp("FILE", "Use a stored POG (made by `riglens data build`) instead of boxes.")
    ] = None
    tolerance_pp: Annotated[
        float | None,
        OptionHelp("PP", "Largest change of seen entropy by --voxel auto, percentage points (1)."),
    ] = None
    surroundings: bool = False
    """True if occluders hide objects where points are counted."""
    occluders: Annotated[
        tuple[Path, Path] | None,
        OptionHelp(
            "OCCLUDERS POSES",
            "Occluders for your own --boxes, and the car's pose in each frame.",
        ),
    ] = None
    rigs: tuple[Rig, ...] = ()
    """Whom an automatic voxel edge has to suit, as `score` scores them."""
    score: ScoreOptions = ScoreOptions()

    def __post_init__(self) -> None:
        if self.tolerance_pp is None:
            return
        if self.voxel_m != "auto":
            raise InputError("belongs to automatic voxels: choose auto for", "tolerance_pp", "voxel_m")
        if not 0.0 <= self.tolerance_pp <= 100.0:
            raise InputError(
                f"must be between 0 and 100 percentage points (got {self.tolerance_pp:g})", "tolerance_pp"
            )

    @property
    def files(self) -> tuple[Path, ...]:
        """Return the given files and folders that are read."""
        return tuple(path for path in (self.boxes, self.pog, *(self.occluders or ())) if path is not None)

    def as_required(self, settings: Settings, where: Path) -> SceneOptions:
        """Return the options with the grid that a file of requirements demands; raise InputError if `voxel_m` or
        `roi_m` contradicts. What a stored POG has is known once it is read."""
        from riglens.core.review.requirements import size_text

        grid: dict[str, Any] = {}
        for name in ("voxel_m", "roi_m"):
            wanted, given = getattr(settings, name), getattr(self, name)
            if given not in (None, wanted):
                got = given if isinstance(given, str) else size_text(given)
                raise InputError(f"must be {size_text(wanted)}, as {where} requires (got {got})", name)
            if wanted != type(settings).model_fields[name].default:
                grid[name] = wanted
        return self if self.pog is not None else replace(self, **grid)

    def surrounded(self, said: str | None, in_town: bool = False) -> SceneOptions:
        """Return the same where occluders hide objects if "block" was said, and by default where tables of them are
        given; `in_town`: in the bundled town, too."""
        usual = self.occluders is not None or (in_town and self.boxes is None)
        return replace(self, surroundings=usual if said is None else said == "block")

    def for_rigs(self, rigs: Sequence[Rig], score: ScoreOptions) -> SceneOptions:
        """Return the same with the rigs that an automatic voxel edge has to suit."""
        return replace(self, rigs=tuple(rigs), score=score) if self.voxel_m == "auto" else self


@dataclass(frozen=True)
class CountOptions:
    """Options of counting points and pixels on objects; what they say beyond `sample` is checked by `settings`."""

    within_m: Annotated[
        float, OptionHelp("M", "Count objects within this distance of the car, in metres.")
    ] = 60.0
    sample: Annotated[
        int | None,
        OptionHelp("N", "Number of frames to use instead of all, drawn at random; ± is two standard errors."),
    ] = None
    shape: Annotated[Literal["class", "box"], SHAPE] = "class"
    range_law: Annotated[bool, RANGE_LAW] = True
    phase: Annotated[Literal["random", "0"], PHASE] = "random"
    seed: Annotated[int, OptionHelp("N", "Seed of the random draws.")] = 0
    min_points: Annotated[int, OptionHelp("N", "Number of LiDAR points that make an object detectable.")] = 5
    calibration: Annotated[
        Path | None,
        OptionHelp(
            "FILE",
            "Calibration of predicted detection, from `riglens calibrate` (default: the bundled one).",
        ),
    ] = None

    def __post_init__(self) -> None:
        if self.sample is not None and self.sample < 1:
            raise InputError(f"must be an integer ≥ 1 (got {self.sample})", "sample")

    def settings(self, body: Body | None) -> TargetSettings:
        """Return the settings of counting; raise InputError for a calibration that cannot be read."""
        from riglens.core.targets.calibration import read_calibration
        from riglens.core.targets.settings import TargetSettings

        curves = None if self.calibration is None else read_calibration(self.calibration)
        return TargetSettings(
            self.shape, self.range_law, self.phase, self.seed, self.min_points, body, curves
        )


@dataclass(frozen=True)
class ReportOptions:
    """Options of what a report holds, and words of the reader's own for its header."""

    requirements: Annotated[Path | None, REQUIREMENTS] = None
    draws: Annotated[int, OptionHelp("N", "Draws of the tolerance; 0 for none.")] = 32
    seed: Annotated[int, OptionHelp("N", "Seed of the draws.")] = 0
    project: Annotated[str | None, OptionHelp("TEXT", "The project, for the header.")] = None
    revision: Annotated[
        str | None, OptionHelp("TEXT", "The revision of the rigs or of the report, for the header.")
    ] = None
    author: Annotated[str | None, OptionHelp("TEXT", "The author, for the header.")] = None
    reviewer: Annotated[str | None, OptionHelp("TEXT", "The reviewer, for the header.")] = None

    def __post_init__(self) -> None:
        from riglens.core.review.tolerance import require_draws

        require_draws(self.draws, self.seed, 0)
        for name, text in self.labels.items():
            if text is not None and len(text) > MOST_LETTERS:
                raise InputError(f"must have at most {MOST_LETTERS} characters (got {len(text)})", name)

    @property
    def labels(self) -> dict[str, str | None]:
        """The words of the header."""
        return {name: getattr(self, name) for name in ("project", "revision", "author", "reviewer")}
