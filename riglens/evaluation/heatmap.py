"""Select and colour the cells of the display grid; the same for window and pictures."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.engine.inspect import covered_at_least
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import Words
from riglens.core.view.display import DisplayGrid
from riglens.core.view.top_view import SeenBy
from riglens.evaluation.options import HEAT_TITLES, HeatMode
from riglens.widgets.heatmap.scale import HeatmapData

COUNT_LABELS = ("0", "1", "2", "3+")
REDUNDANT: dict[HeatMode, str] = dict.fromkeys(("twice", "thrice", "kinds"), "; more is better")
"""Modes of redundancy: the entropy that several sensors see, and the way in which it gets better."""
Values = NDArray[np.float32]
NO_WORDS = np.empty(0, np.uint64)


@dataclass(frozen=True)
class VoxelMarks:
    """Inputs of the modes besides the POG: the voxels seen now and by the baseline, and by at least 1, 2, 3 sensors.

    Those that the mode does not need (`marks_for`) are empty.
    """

    seen: Words
    levels: NDArray[np.uint64]
    baseline: Words
    baseline_name: str = ""


SEEN_BY: dict[HeatMode, SeenBy] = {
    "seen": "any", "unseen": "any", "change": "any", "twice": "twice", "thrice": "thrice", "kinds": "kinds",
}  # fmt: skip
"""Coverage that each mode shows, of the modes that show any."""


def needs_seen(mode: HeatMode) -> bool:
    """Return whether an evaluation has to return the seen voxels for a mode."""
    return SEEN_BY.get(mode) in ("any", "kinds")


def seen_by(by: SeenBy, engine: Engine, evaluation: Evaluation) -> Words:
    """Return the voxels seen in the evaluation that the engine has just made; call it on the engine's thread."""
    if by in ("twice", "thrice"):
        levels = covered_at_least(engine, evaluation.rig, evaluation.settings.method)
        many: Words = levels[1 if by == "twice" else 2]
        return many
    if by == "kinds":
        return evaluation.seen_by_two_kinds()
    return evaluation.seen_by_any() if by == "any" else evaluation.seen[by]


def marks_of(evaluation: Evaluation) -> VoxelMarks:
    """Return the inputs from an evaluation that holds the seen voxels, without a baseline."""
    return VoxelMarks(evaluation.seen_by_any(), NO_WORDS, NO_WORDS)


def marks_for(mode: HeatMode, engine: Engine, evaluation: Evaluation) -> VoxelMarks:
    """Return the inputs of a mode from an evaluation that the engine has just made, on the engine's thread."""
    if mode == "sensors":
        levels = covered_at_least(engine, evaluation.rig, evaluation.settings.method)
        return VoxelMarks(NO_WORDS, levels, NO_WORDS)
    seen = seen_by(SEEN_BY[mode], engine, evaluation) if mode in SEEN_BY else NO_WORDS
    return VoxelMarks(seen, NO_WORDS, NO_WORDS)


@dataclass(frozen=True)
class _Base:
    """Parts that stay the same in a drag: the non-empty cells, their full values and the scale."""

    shown: NDArray[np.bool_]
    centres_m: Values
    full: Values
    vmax: float


class Heatmaps:
    """Maker of heatmaps on a display grid.

    Which cells are shown depends on mode and class only, and they come back as the same array, so that a view
    has to change nothing but values in a drag. What does not depend on the rig at all comes back as the same object, so
    that it has to change nothing.
    """

    def __init__(self, display: DisplayGrid) -> None:
        self.display = display
        self._bases: dict[tuple[bool, str], _Base] = {}
        self._of_any_rig: dict[tuple[HeatMode, str], HeatmapData] = {}

    def heatmap(self, mode: HeatMode, class_name: str, marks: VoxelMarks) -> HeatmapData | None:
        """Return the heatmap of a mode; None when it is "off"."""
        if mode == "off":
            return None
        if mode not in ("probability", "entropy"):
            return self._made(mode, class_name, marks)
        if (mode, class_name) not in self._of_any_rig:
            self._of_any_rig[mode, class_name] = self._made(mode, class_name, marks)
        return self._of_any_rig[mode, class_name]

    def _made(self, mode: HeatMode, class_name: str, marks: VoxelMarks) -> HeatmapData:
        base = self._base(mode == "probability", class_name)
        if mode == "sensors":
            return self._sensors(base, class_name, marks)
        values = self._values(mode, base, CLASSES.index(class_name), marks)
        is_change = mode == "change"
        note = self._note("largest" if mode == "probability" else "sum")
        return HeatmapData(
            centres_m=base.centres_m,
            cell_m=self.display.cell_m,
            values=values,
            title=f"{HEAT_TITLES[mode]}, {class_name}",
            unit="" if mode == "probability" else "nat",
            vmin=0.0,
            vmax=_round_above(values, base.vmax) if is_change else base.vmax,
            note=f"against {marks.baseline_name}: {note}" if is_change else note + REDUNDANT.get(mode, ""),
            scale="change" if is_change else "ramp",
        )

    def _values(self, mode: HeatMode, base: _Base, cls: int, marks: VoxelMarks) -> Values:
        """Return a value for each cell shown."""
        if mode in ("probability", "entropy"):
            return base.full
        if mode == "change":
            gained = self.display.seen_entropy(cls, marks.seen & ~marks.baseline)
            return (gained - self.display.seen_entropy(cls, marks.baseline & ~marks.seen))[base.shown]
        share = self.display.seen_share(cls, marks.seen)[base.shown]
        return base.full * (1.0 - share if mode == "unseen" else share)

    def _sensors(self, base: _Base, class_name: str, marks: VoxelMarks) -> HeatmapData:
        """Return the heatmap of the number of sensors that see the larger part of each cell; opacity by entropy."""
        return HeatmapData(
            centres_m=base.centres_m,
            cell_m=self.display.cell_m,
            values=self.display.prevailing(CLASSES.index(class_name), marks.levels)[base.shown],
            title=f"{HEAT_TITLES['sensors']}, {class_name}",
            unit="",
            vmin=0.0,
            vmax=float(len(COUNT_LABELS) - 1),
            note=self._note("majority"),
            scale="steps",
            labels=COUNT_LABELS,
            weights=(base.full / base.vmax) ** np.float32(0.5),
        )

    def _base(self, is_probability: bool, class_name: str) -> _Base:
        key = (is_probability, class_name)
        if key not in self._bases:
            cls = CLASSES.index(class_name)
            full = self.display.probability(cls) if is_probability else self.display.entropy(cls)
            shown = full > 0
            centres_m = np.ascontiguousarray(self.display.centres_m[shown])
            self._bases[key] = _Base(shown, centres_m, full[shown], float(full.max(initial=0.0)) or 1.0)
        return self._bases[key]

    def _note(self, how: str) -> str:
        """Return a note on the grid that the picture shows; the scores always use the full one."""
        cell_m, block = self.display.cell_m, self.display.block
        cells = f"cells of {cell_m:.4g} m"
        return cells if block == 1 else f"{cells}, {how} of {block}³ voxels"


def _round_above(values: Values, limit: float) -> float:
    """Return the next 1, 2 or 5 times a power of ten above all sizes, so that the scale stays fixed in most of a drag.

    At least a thousandth of `limit`, which is what it is, roughly, without any change.
    """
    most = max(float(np.abs(values).max(initial=0.0)), 1e-3 * limit)
    power = 10.0 ** math.floor(math.log10(most))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= most)
