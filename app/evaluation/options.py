"""What can be asked of a scene, a score and a heatmap: plain data, cheap to import."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from riglens.core.errors import InputError
from riglens.core.metric.scores import MAX_LAMBDA, Body

if TYPE_CHECKING:  # the model of rigs takes its time, and `riglens --help` needs none
    from riglens.core.rig.model import Rig

Triple = tuple[float, float, float]

DEFAULT_RIG = "nuScenes car"
"""The rig that the window starts on."""
PAPER_RIG = "W+T"
"""The rig of the paper's figures."""
DEFAULT_TOLERANCE_PP = 1.0
USUAL_DRAWS = 32
"""Draws of the tolerance in a report."""
MAX_THREADS = 1024
MIN_SIDE_PX, MAX_SIDE_PX, MAX_SCALE = 64, 8192, 4
"""Sides of a picture before it is enlarged, and how many times it may be."""

HeatMode = Literal[
    "off", "probability", "entropy", "seen", "unseen", "sensors", "change", "twice", "thrice", "kinds"
]  # fmt: skip
HEAT_TITLES: dict[HeatMode, str] = {
    "off": "Off",
    "probability": "POG probability",
    "entropy": "Entropy",
    "seen": "Seen entropy",
    "unseen": "Unseen entropy",
    "sensors": "Sensors that see it",
    "change": "Gained and lost",
    "twice": "Seen by at least 2",
    "thrice": "Seen by at least 3",
    "kinds": "Seen by both kinds",
}
"""What the heatmap can show of voxels: the modes by their keys, and what they are called."""
TargetHeatMode = Literal["on_target", "missed"]
TARGET_HEAT_TITLES: dict[TargetHeatMode, str] = {"on_target": "On target", "missed": "Missed road users"}
"""What it can show of road users, in the window."""


def require_solid(body: Body | None) -> None:
    """Refuse rays through the car where it is always solid; InputError."""
    if body == "ignored":
        raise InputError(
            "--body must be blocks (got ignored): here the car is always solid; leave --body out"
        )


@dataclass(frozen=True)
class ScoreOptions:
    """How the score is computed; checked here so that a typing error costs no evaluation."""

    method: Literal["exact", "bresenham"] = "exact"
    reading: Literal["covered", "residual", "hits"] = "covered"
    camera_weight: float = 0.1
    threads: int | None = None
    body: Body | None = None
    """Of all rigs, for this run; None: as each rig says."""

    def as_required(self, body: Body | None, where: Path) -> ScoreOptions:
        """The same with the body that a file of requirements says, if it does; InputError where --body contradicts."""
        if None not in (self.body, body) and self.body != body:
            raise InputError(
                f"--body must be {body}, as {where} requires (got {self.body}); leave --body out"
            )
        return replace(self, body=self.body or body)

    def body_of(self, rig: Rig) -> Body:
        """Whether rays end at a rig's own body."""
        return self.body or rig.body

    def __post_init__(self) -> None:
        if not 0.0 <= self.camera_weight <= MAX_LAMBDA:
            found = f"{self.camera_weight:g}"
            raise InputError(f"--lambda: found {found}, accepted is a number from 0 to {MAX_LAMBDA:,.0f}")
        if self.threads is not None and not 1 <= self.threads <= MAX_THREADS:
            shown = f"{self.threads}" if abs(self.threads) < 1 << 64 else "a very large number"
            raise InputError(f"--threads: found {shown}, accepted is a whole number from 1 to {MAX_THREADS}")


@dataclass(frozen=True)
class AutoVoxel:
    """Pick the voxel edge by the scores of some rigs; `tolerance_pp` is in percentage points of H(Omega)."""

    tolerance_pp: float = DEFAULT_TOLERANCE_PP
    rigs: tuple[Rig, ...] = ()
    score: ScoreOptions = ScoreOptions()

    def __post_init__(self) -> None:
        if not 0.0 <= self.tolerance_pp <= 100.0:
            raise InputError(
                f"--tolerance: found {self.tolerance_pp:g}, accepted are percentage points from 0 to 100"
            )


@dataclass(frozen=True)
class SceneOptions:
    """Which boxes and which grid; None means "not said" (the bundled scenario, the default grid).

    `surroundings`: whether what stands around hides road users where points are counted; `occluders`: the tables of it
    and of the poses, for box data of one's own. `auto` takes the place of a voxel edge; `find_ground` puts the ground
    at z = 0, by the bottoms of the boxes. The numbers are checked where they are used: by grid and readers.
    """

    boxes: Path | None = None
    origin_m: Triple | None = None
    frames: int | None = None
    classes: tuple[str, ...] = ()
    voxel_m: float | None = None
    roi_m: Triple | None = None
    pog: Path | None = None
    auto: AutoVoxel | None = None
    find_ground: bool = False
    surroundings: bool = False
    occluders: tuple[Path, Path] | None = None

    @property
    def files(self) -> tuple[Path, ...]:
        """What is read of them, as far as it is said."""
        return tuple(path for path in (self.boxes, self.pog, *(self.occluders or ())) if path is not None)

    def for_rigs(self, rigs: Sequence[Rig], score: ScoreOptions) -> SceneOptions:
        """The same with the rigs that an automatic voxel edge has to suit; without one nothing changes."""
        if self.auto is None:
            return self
        return replace(self, auto=replace(self.auto, rigs=tuple(rigs), score=score))
