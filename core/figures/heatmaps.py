"""Define heatmaps: a value of each cell of space, made from the voxels or from the objects that a rig sees."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from riglens.core.figures.figure import Better
from riglens.core.figures.hits import CAMERAS, MISSED, ON_TARGET, Doubles
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.text import UNITS, in_sentence, in_unit
from riglens.core.figures.voxel_sets import ANY, THRICE, TWICE, TWO_KINDS, VoxelSet
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.settings import NEAR_M
from riglens.core.view.heatmap_data import HeatmapData, Scale, Values

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.engine.engine import Engine, Evaluation
    from riglens.core.figures.evaluated import Need
    from riglens.core.scene.columns import Words
    from riglens.core.targets.camera_losses import CameraLosses
    from riglens.core.targets.ground import GroundView
    from riglens.core.view.display import DisplayGrid

OFF = "off"
"""Key of no heatmap."""
COUNT_LABELS = ("0", "1", "2", "3+")
NO_WORDS = np.empty(0, np.uint64)
FAINTEST = 0.35
"""Opacity of cells with almost no objects, as a share of that of the others: their figures are also visible there."""


@dataclass(frozen=True, kw_only=True)
class HeatMap(ABC):
    """A heatmap of one class: what the cells show.

    key: its name on the command line, in settings and in Python; question: one sentence that says what a cell shows,
    for tooltips, help and docs; shortcut: its keys in the window; needs: what has to be evaluated for it.
    """

    key: str
    title: str
    question: str
    shortcut: str = ""
    unit: str = "nat"
    scale: Scale = "ramp"
    better: Better = "neither"

    def __post_init__(self) -> None:
        if self.key == OFF:
            raise ValueError(f"'{OFF}' is no heatmap")

    @property
    @abstractmethod
    def needs(self) -> Need:
        """Part of an evaluation that it reads."""

    @property
    def direction(self) -> str:
        """Return which way it gets better, in words; "" where it has no direction."""
        return "" if self.better == "neither" else f"{self.better} is better"


# ---------------------------------------------------------------- of voxels
@dataclass(frozen=True)
class Marks:
    """Sets of voxels that a heatmap shows: `seen` (words,) or nested sets (n, words), `baseline` those of the baseline
    where the heatmap compares with it, else empty."""

    seen: NDArray[np.uint64] = field(default_factory=lambda: NO_WORDS)
    baseline: NDArray[np.uint64] = field(default_factory=lambda: NO_WORDS)
    baseline_name: str = ""


@dataclass(frozen=True)
class FullCells:
    """Parts that stay the same in a drag: the non-empty cells, their full values and the scale."""

    shown: NDArray[np.bool_]
    centres_m: Values
    values: Values
    vmax: float


class Heatmaps:
    """Maker of heatmaps of voxels on a display grid.

    Which cells are shown depends on heatmap and class only, and they come back as the same array, so that a view
    has to change nothing but values in a drag. What does not depend on the rig at all comes back as the same object, so
    that it has to change nothing.
    """

    def __init__(self, display: DisplayGrid) -> None:
        self.display = display
        self._full: dict[tuple[bool, str], FullCells] = {}
        self._of_any_rig: dict[tuple[str, str], HeatmapData] = {}

    def drawn(self, heat: VoxelHeatMap, class_name: str, marks: Marks) -> HeatmapData:
        """Return the data of a heatmap."""
        if heat.of_rig:
            return heat.data(self, class_name, marks)
        key = (heat.key, class_name)
        if key not in self._of_any_rig:
            self._of_any_rig[key] = heat.data(self, class_name, marks)
        return self._of_any_rig[key]

    def full(self, class_name: str, of_probability: bool = False) -> FullCells:
        """Return the cells with any entropy, or with any probability."""
        key = (of_probability, class_name)
        if key not in self._full:
            cls = CLASSES.index(class_name)
            values = self.display.probability(cls) if of_probability else self.display.entropy(cls)
            shown = values > 0
            centres_m = np.ascontiguousarray(self.display.centres_m[shown])
            self._full[key] = FullCells(
                shown, centres_m, values[shown], float(values.max(initial=0.0)) or 1.0
            )
        return self._full[key]

    def note(self, how: str) -> str:
        """Return a note on the grid that the picture shows; the scores always use the full one."""
        cell_m, block = self.display.cell_m, self.display.block
        cells = f"cells of {cell_m:.4g} m"
        return cells if block == 1 else f"{cells}, {how} of {block}³ voxels"


@dataclass(frozen=True, kw_only=True)
class VoxelHeatMap(HeatMap):
    """A heatmap of the entropy of voxels: of all of them, of those in a set, or of the `rest` outside it."""

    voxels: VoxelSet | None = None
    is_rest: bool = False

    @property
    def needs(self) -> Need:
        return "voxels"

    @property
    def of_rig(self) -> bool:
        """Return whether it depends on the rig."""
        return self.voxels is not None

    @property
    def is_against_baseline(self) -> bool:
        """Return whether it also takes the sets of a baseline."""
        return False

    def sets(self, engine: Engine, evaluation: Evaluation) -> NDArray[np.uint64]:
        """Return the sets of voxels that it shows, of the evaluation that the engine has just made, on its thread; the
        evaluation holds what is seen where the heatmap depends on the rig."""
        return NO_WORDS if self.voxels is None else self.voxels.of(engine, evaluation)

    def data(self, cells: Heatmaps, class_name: str, marks: Marks) -> HeatmapData:
        """Return the cells of a class."""
        full = cells.full(class_name)
        direction = self.direction if self.voxels is not None and self.voxels.is_of_several else ""
        note = "; ".join(filter(None, (cells.note("sum"), direction)))
        if self.voxels is None:
            return self._with(cells, full, class_name, full.values, note)
        share = cells.display.seen_share(CLASSES.index(class_name), marks.seen)[full.shown]
        return self._with(
            cells, full, class_name, full.values * (1.0 - share if self.is_rest else share), note
        )

    def meant(self, marks: Marks, value: float) -> Words | None:
        """Return the voxels that a click on a cell with a value may mean; None when any may be meant."""
        if not self.of_rig or not marks.seen.size:
            return None
        return ~marks.seen if self.is_rest else marks.seen

    def _with(
        self, cells: Heatmaps, full: FullCells, class_name: str, values: Values, note: str, vmax: float = 0.0
    ) -> HeatmapData:
        title, vmax = f"{self.title}, {class_name}", vmax or full.vmax
        return HeatmapData(
            full.centres_m, cells.display.cell_m, values, title, self.unit, 0.0, vmax, note, self.scale
        )


@dataclass(frozen=True, kw_only=True)
class Probability(VoxelHeatMap):
    """The largest probability of a cell's voxels."""

    def data(self, cells: Heatmaps, class_name: str, marks: Marks) -> HeatmapData:
        full = cells.full(class_name, of_probability=True)
        return self._with(cells, full, class_name, full.values, cells.note("largest"))


@dataclass(frozen=True, kw_only=True)
class SensorCount(VoxelHeatMap):
    """The number of sensors that see the larger part of each cell; opacity by entropy."""

    scale: Scale = "steps"

    @property
    def of_rig(self) -> bool:
        return True

    def sets(self, engine: Engine, evaluation: Evaluation) -> NDArray[np.uint64]:
        from riglens.core.engine.inspect import covered_at_least  # loads the compiler

        return covered_at_least(engine, evaluation.rig, evaluation.settings.method)

    def data(self, cells: Heatmaps, class_name: str, marks: Marks) -> HeatmapData:
        full = cells.full(class_name)
        return HeatmapData(
            centres_m=full.centres_m,
            cell_m=cells.display.cell_m,
            values=cells.display.prevailing(CLASSES.index(class_name), marks.seen)[full.shown],
            title=f"{self.title}, {class_name}",
            unit=self.unit,
            vmin=0.0,
            vmax=float(len(COUNT_LABELS) - 1),
            note=cells.note("majority"),
            scale=self.scale,
            labels=COUNT_LABELS,
            weights=(full.values / full.vmax) ** np.float32(0.5),
        )

    def meant(self, marks: Marks, value: float) -> Words | None:
        return None


@dataclass(frozen=True, kw_only=True)
class Change(VoxelHeatMap):
    """The entropy that a set of the rig holds and that of the baseline does not, minus the reverse."""

    voxels: VoxelSet
    scale: Scale = "change"

    @property
    def is_against_baseline(self) -> bool:
        return True

    def data(self, cells: Heatmaps, class_name: str, marks: Marks) -> HeatmapData:
        full, cls = cells.full(class_name), CLASSES.index(class_name)
        gained = cells.display.seen_entropy(cls, marks.seen & ~marks.baseline)
        values = (gained - cells.display.seen_entropy(cls, marks.baseline & ~marks.seen))[full.shown]
        note = f"against {marks.baseline_name}: {cells.note('sum')}"
        return self._with(cells, full, class_name, values, note, _round_above(values, full.vmax))

    def meant(self, marks: Marks, value: float) -> Words | None:
        if not marks.seen.size:
            return None
        is_lost = value < 0.0  # the larger part of the cell, which gives it its colour
        return ~marks.seen & marks.baseline if is_lost else marks.seen & ~marks.baseline


def _round_above(values: Values, limit: float) -> float:
    """Return the next 1, 2 or 5 times a power of ten above all sizes, so that the scale stays fixed in most of a drag.

    At least a thousandth of `limit`, which is what it is, roughly, without any change.
    """
    most = max(float(np.abs(values).max(initial=0.0)), 1e-3 * limit)
    power = 10.0 ** math.floor(math.log10(most))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= most)


# ---------------------------------------------------------------- of objects
@dataclass(frozen=True, eq=False)
class OverGround:
    """A heatmap of objects over the ground, cells (nx, ny): objects with a value near each, and their mean (NaN where
    there are none), or the number of those that lack something. Equal only to itself."""

    heat: ObjectHeatMap
    ground: GroundView
    objects: NDArray[np.int64]
    values: NDArray[np.float64]

    @property
    def top(self) -> float:
        """Return the end of the scale, which begins with 0."""
        if self.heat.unit == "%":
            return 100.0
        return max(float(np.nan_to_num(self.values).max(initial=0.0)), 1.0)


@dataclass(frozen=True, kw_only=True)
class ObjectHeatMap(HeatMap):
    """A figure of objects over the ground, of all frames: the mean of those near each cell, or their sum where they
    `are_counted`; with_losses: whether it reads what hides objects from cameras."""

    figure: ObjectFigure
    are_counted: bool = False
    with_losses: bool = False

    @classmethod
    def of(cls, figure: ObjectFigure, shortcut: str = "") -> ObjectHeatMap:
        """Return the heatmap of a figure's mean."""
        return cls(
            key=figure.key,
            title=figure.title,
            question=f"{figure.question.removesuffix('.')}; mean of the objects {_NEAR}.",
            shortcut=shortcut,
            unit=UNITS[figure.unit],
            scale="level",
            better=figure.better,
            figure=figure,
        )

    @property
    def needs(self) -> Need:
        return "objects"

    @property
    def on_map(self) -> str:
        """Return the title of the map."""
        return in_sentence(self.title)

    def over(self, ground: GroundView) -> OverGround:
        """Return the values over the ground, in the heatmap's unit."""
        values = self.figure.values(ground.counted)
        objects, sums = ground.near(values)
        if self.are_counted:
            return OverGround(self, ground, objects, sums)
        means = np.divide(sums, objects, out=np.full(sums.shape, np.nan), where=objects > 0)
        means = np.maximum(means, self.figure.least)
        return OverGround(self, ground, objects, in_unit(self.figure, means))

    def data(self, over: OverGround, is_current: bool = True) -> HeatmapData:
        """Return the cells on the ground with objects near them; `is_current`: no edit is being counted."""
        ground = over.ground
        ix, iy = np.nonzero(over.objects)
        x_m, y_m = (low + (i + 0.5) * ground.cell_m for low, i in zip(ground.origin_m, (ix, iy), strict=True))
        centres_m = np.stack([x_m, y_m, np.full(len(ix), ground.cell_m / 2)], axis=1).astype(np.float32)
        what = f"objects within {ground.near_m:g} m" if is_current else "recounting"
        weights = None
        if self.scale == "level":
            many = over.objects[ix, iy] / max(int(over.objects.max(initial=1)), 1)
            weights = (FAINTEST + (1.0 - FAINTEST) * np.sqrt(many)).astype(np.float32)
        return HeatmapData(
            centres_m, ground.cell_m, over.values[ix, iy].astype(np.float32), f"{self.title}, {ground.class_name}",
            self.unit, 0.0, over.top, " · ".join(filter(None, (self.direction, what))), self.scale, weights=weights,
            is_loss=self.better == "less",
        )  # fmt: skip


_NEAR = f"within {NEAR_M:g} m of each metre of ground, in all frames"


def _part(voxels: VoxelSet) -> VoxelHeatMap:
    """Return the entropy in a set of voxels."""
    sensors = " sensors" if voxels.least > 1 else ""
    question = f"The part of the entropy in voxels seen by {voxels.seen_by}{sensors}."
    return VoxelHeatMap(
        key=voxels.key, title=f"Seen by {voxels.seen_by}", question=question, better="more", voxels=voxels
    )


def _lost(key: str, title: str, what: str, values: Callable[[CameraLosses], Doubles]) -> ObjectHeatMap:
    """Return a share of silhouettes that the camera loses whose picture shows most of an object."""
    figure = ObjectFigure(
        key=f"lost_{key}",
        title=title,
        question=f"Share of an object's silhouette that {what} the picture that shows most of it.",
        better="less",
        kinds=CAMERAS,
        values=lambda counted: (
            np.full(len(counted.objects.box), np.nan) if counted.losses is None else values(counted.losses)
        ),
    )
    return replace(ObjectHeatMap.of(figure), with_losses=True)


PROBABILITY = Probability(
    key="probability",
    title="POG probability",
    question="Largest probability of occupancy of a cell's voxels.",
    shortcut="Alt+1",
    unit="",
)
ENTROPY = VoxelHeatMap(
    key="entropy", title="Entropy", question="Entropy of a cell's voxels, summed.", shortcut="Alt+2"
)
SEEN_ENTROPY = VoxelHeatMap(
    key="seen",
    title="Seen traffic",
    question="The part of the entropy in voxels that at least one sensor sees.",
    shortcut="Alt+3",
    better="more",
    voxels=ANY,
)
UNSEEN_ENTROPY = VoxelHeatMap(
    key="unseen",
    title="Unseen traffic",
    question="The part of the entropy in voxels that no sensor sees.",
    shortcut="Alt+4",
    better="less",
    voxels=ANY,
    is_rest=True,
)
SENSORS = SensorCount(
    key="sensors",
    title="Number of sensors",
    question="Number of sensors that see most of a cell's entropy; cells with little entropy are faint.",
    shortcut="Alt+5",
    unit="",
)
CHANGE = Change(
    key="change",
    title="Gained and lost",
    question="The entropy that the rig sees and the baseline does not, minus the reverse.",
    shortcut="Alt+6",
    better="more",
    voxels=ANY,
)
SEEN_TWICE, SEEN_THRICE, SEEN_BY_TWO_KINDS = map(_part, (TWICE, THRICE, TWO_KINDS))
OF_TARGETS = ObjectHeatMap.of(ON_TARGET, "Alt+7")
MISSED_OBJECTS = ObjectHeatMap(
    key="missed",
    title="Missed objects",
    question=f"The number of objects {_NEAR}, that no sensor detects.",
    shortcut="Alt+8",
    unit="objects",
    better="less",
    figure=MISSED,
    are_counted=True,
)
LOST_OUTSIDE = _lost("outside", "Outside the picture", "lies outside", lambda lost: lost.outside)
LOST_BEHIND_TRAFFIC = _lost(
    "traffic", "Hidden by traffic", "other objects hide in", lambda lost: lost.traffic
)
LOST_BEHIND_CAR = _lost("car", "Hidden by own body", "the car itself hides in", lambda lost: lost.car)
