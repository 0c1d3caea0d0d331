"""What a command can be told about the scene and the score: plain data, cheap to import."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from core.errors import InputError

Triple = tuple[float, float, float]

DEFAULT_RIG = "W+T"


@dataclass(frozen=True)
class SceneOptions:
    """Which boxes and which grid; None means "not said" (the bundled scenario, the default grid).

    The numbers are checked where they are used: by the grid and by the readers.
    """

    boxes: Path | None = None
    origin_m: Triple | None = None
    frames: int | None = None
    classes: tuple[str, ...] = ()
    voxel_m: float | None = None
    roi_m: Triple | None = None
    pog: Path | None = None


@dataclass(frozen=True)
class ScoreOptions:
    """How the score is computed; checked here so that a typing error costs no evaluation."""

    method: Literal["exact", "bresenham"] = "exact"
    reading: Literal["covered", "residual", "hits"] = "covered"
    camera_weight: float = 0.1
    threads: int | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.camera_weight) and self.camera_weight >= 0.0):
            raise InputError(f"--lambda: found {self.camera_weight:g}, accepted is a finite number from 0 up")
        if self.threads is not None and self.threads < 1:
            raise InputError(f"--threads: found {self.threads}, accepted is a whole number from 1 up")
