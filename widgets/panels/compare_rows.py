"""Rigs to compare: what a row holds, what its columns are, and the whole as text for spreadsheets."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from riglens.core.metric.scores import ClassScores, Scores
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.widgets.panels.score_text import COLUMNS, Column, column_of

Origin = Literal["current", "snapshot", "preset", "file"]
ORIGIN_TITLES: dict[Origin, str] = {
    "current": "being edited",
    "snapshot": "snapshot",
    "preset": "preset",
    "file": "file",
}
ALL_CLASSES = "all classes"
_SHORT_CLASSES = {"pedestrian": "ped."}
_SHOWN_OF_ALL = {"s_ms": "S-MS", "seen": "seen"}


@dataclass(frozen=True)
class CompareRow:
    """One rig; `where` is its preset's name or its path, `scores` None until they are computed."""

    key: str
    name: str
    origin: Origin
    rig: Rig
    where: str = ""
    scores: Scores | None = None

    @property
    def title(self) -> str:
        """The name as it is shown; the rig being edited may be called like the preset that it began as."""
        return f"{self.name} (open)" if self.origin == "current" else self.name

    @property
    def sensors(self) -> str:
        """How many sensors count, by kind."""
        return f"{len(self.rig.lidars())} L + {len(self.rig.cameras())} C"


@dataclass(frozen=True)
class ScoreColumn:
    """One number per rig: a score of a class."""

    class_name: str
    score: Column
    title: str

    @property
    def short(self) -> str:
        """The title where there is little room."""
        return self.title.replace(self.class_name, _SHORT_CLASSES.get(self.class_name, self.class_name))

    def value(self, scores: Scores) -> float:
        """The number, in nat or as a fraction."""
        return self.score.value(scores.classes[self.class_name])


def columns_for(class_name: str) -> tuple[ScoreColumn, ...]:
    """All scores of one class, or S-MS and `seen` of every class for ALL_CLASSES."""
    if class_name != ALL_CLASSES:
        return tuple(ScoreColumn(class_name, column, column.title) for column in COLUMNS)
    return tuple(
        ScoreColumn(name, column_of(key), f"{name} {title}")
        for name in CLASSES
        for key, title in _SHOWN_OF_ALL.items()
    )


_FIELDS: tuple[tuple[str, Callable[[ClassScores], float]], ...] = (
    ("H total (nat)", lambda c: c.h_total),
    ("camera S-MIG (nat)", lambda c: c.camera.s_mig),
    ("camera seen (fraction)", lambda c: c.camera.seen),
    ("LiDAR S-MIG (nat)", lambda c: c.lidar.s_mig),
    ("LiDAR seen (fraction)", lambda c: c.lidar.seen),
    ("S-MS (nat)", lambda c: c.s_ms),
    ("seen (fraction)", lambda c: c.any_seen),
)


def table_text(rows: Sequence[CompareRow], delimiter: str) -> str:
    """Every rig with every number and every digit, whatever the window shows of it; one line per rig."""
    stream = io.StringIO()
    writer = csv.writer(stream, delimiter=delimiter, lineterminator="\n")
    titles = [f"{name} {title}" for name in CLASSES for title, _ in _FIELDS]
    writer.writerow(["rig", "origin", "where", "LiDARs", "cameras", *titles])
    for row in rows:
        counts = [len(row.rig.lidars()), len(row.rig.cameras())]
        writer.writerow([row.name, ORIGIN_TITLES[row.origin], row.where, *counts, *_numbers(row.scores)])
    return stream.getvalue()


def _numbers(scores: Scores | None) -> list[str]:
    if scores is None:
        return [""] * (len(CLASSES) * len(_FIELDS))
    return [repr(read(scores.classes[name])) for name in CLASSES for _, read in _FIELDS]
