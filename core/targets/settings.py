"""Define the settings and assumptions for counting points on objects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from riglens.core.errors import InputError
from riglens.core.metric.scores import Body
from riglens.core.plain import to_plain
from riglens.core.targets.calibration import Calibration, shipped_recall
from riglens.core.targets.shapes import Shape

Phase = Literal["random", "0"]
CELLS_SCALE = 5.0
"""on_target = mean over objects of 1 - exp(-cells / 5)."""
RING_M, RINGS_TO_M = 10.0, 100.0
"""Width of the rings; what lies beyond the second number makes one more ring."""
HALF = 0.5
"""An object of which a picture shows this share is detected by its camera: our choice."""
HEIGHT_PX = 25
"""Height that KITTI requires of moderate and hard objects; no criterion of detection here, where it would say that
narrow cameras beat wide ones."""
NEAR_M = 2.0
"""Distance within which objects belong to a cell of the ground, between centres of cells: our choice."""


@dataclass(frozen=True)
class TargetSettings:
    """Settings of the counts on objects.

    shape: plain boxes, or the parts of objects of a class. range_law: whether far and oblique rays of LiDARs
    get lost. phase: `random` turns each LiDAR in each frame by a part of its azimuth step, drawn by `seed`, its name
    and the frame; `0` casts the azimuths as they are listed. min_points: an object with this many points of LiDARs is
    detectable. body: whether rays end at the car's own body; None: as each rig says. calibration: of predicted
    detection; None: the one that ships.
    """

    shape: Shape = "class"
    range_law: bool = True
    phase: Phase = "random"
    seed: int = 0
    min_points: int = 5
    body: Body | None = "ignored"
    calibration: Calibration | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.seed < 1 << 63:
            raise InputError(f"must be an integer from 0 to 2^63 - 1 (got {self.seed})", "seed")
        if self.min_points < 1:
            raise InputError(f"must be an integer ≥ 1 (got {self.min_points})", "min_points")

    @property
    def recall(self) -> Calibration | None:
        """The calibration that says which objects are found: the given one, or the bundled one where none is given;
        None for one of AP."""
        if self.calibration is None:
            return shipped_recall()
        return self.calibration if self.calibration.predicts == "recall" else None

    def as_dict(self) -> dict[str, object]:
        """Return the settings as plain data, by the names of the JSON."""
        found: dict[str, object] = to_plain(self, "body", "shape", "range_law", "phase", "seed", "min_points")
        return found


USUAL = TargetSettings()
EXACT = TargetSettings(shape="box", range_law=False, phase="0")
"""Rays as listed against plain boxes: what brute force can check ray by ray."""
