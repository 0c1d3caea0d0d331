"""The rigs of the Compare panel: their rows, and asking for the scores and counts that are not known of them yet."""

from __future__ import annotations

from dataclasses import replace
from itertools import count

from PySide6.QtCore import QObject, Qt, Signal

from riglens.app.background.background_requests import ScoreRequest
from riglens.app.background.counting import CountAnswer, CountRequest, OtherCount
from riglens.app.background.queue import BackgroundRequest
from riglens.app.window.workbench import Workbench
from riglens.core.figures.values import Values
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.rig.model import Rig
from riglens.evaluation.requests import LoadedScene, Result
from riglens.widgets.panels.compare.model import CompareRow, Origin

GROUP = "compare"
CURRENT = "current"


class ComparedRigs(QObject):
    """Rows of rigs, the one being edited first; the others are scored and counted between edits.

     Compared rigs share the same traffic and settings; once these differ all other results are discarded, and
    requested again.
    """

    changed = Signal()
    """A row or its numbers changed, or whether numbers are requested."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self._recompute, self._counter, self._session = bench.recompute, bench.counter, bench.session
        self._rows: dict[str, CompareRow] = {}
        self._numbers = count(1)
        self._scored_on: tuple[LoadedScene, MetricSettings] | None = None
        self._counted: tuple[CountRequest, Values] | None = None
        """Of the rig being edited, in all frames: what else is counted is of the same traffic, in the same way."""
        self.is_given_up = False
        self._asked: set[str] = set()
        self._asked_counts: set[str] = set()
        queued = Qt.ConnectionType.QueuedConnection
        self._recompute.answered_in_background.connect(self._take, queued)
        self._counter.answered_in_background.connect(self._take_count, queued)

    def __getitem__(self, key: str) -> CompareRow:
        return self._rows[key]

    @property
    def rows(self) -> tuple[CompareRow, ...]:
        """The rigs in the order in which they were added, the one being edited first."""
        return tuple(self._rows.values())

    @property
    def missing(self) -> list[CompareRow]:
        """The rows without scores."""
        return [row for row in self._rows.values() if row.scores is None]

    # ------------------------------------------------------------------ rows
    def add(self, name: str, origin: Origin, rig: Rig, where: str = "") -> None:
        """Add a rig, with the numbers of the one being edited when it is the same."""
        key, rig = f"{origin}-{next(self._numbers)}", self._session.with_mesh(rig)
        now = self._rows.get(CURRENT)
        known = (now.scores, now.counted) if now is not None and now.rig == rig else (None, None)
        self._rows[key] = CompareRow(key, name, origin, rig, where, *known)
        self.is_given_up = False
        self._ask()

    def remove(self, keys: tuple[str, ...]) -> None:
        """Remove rigs; the one being edited stays."""
        for key in keys:
            if key != CURRENT:
                self._rows.pop(key, None)
        self._forget()
        self._ask()

    def rename(self, key: str, name: str) -> None:
        """Rename a rig."""
        self._rows[key] = replace(self._rows[key], name=name)
        self.changed.emit()

    def go_on(self, wanted: bool) -> None:
        """Request the missing numbers, or cancel that."""
        self.is_given_up = not wanted
        self._forget()
        self._ask()

    # ------------------------------------------------------------------ the rig being edited
    def take_result(self, result: Result, name: str) -> None:
        """Store the scores of the rig being edited; other traffic or settings discard all other scores."""
        scored_on = (result.scene, result.request.settings)
        if scored_on != self._scored_on:
            self.drop_scores(result.scene)
            self._scored_on = scored_on
        rig = result.request.rig
        counted, figures = self._counted or (None, None)
        if counted is None or counted.rig != rig:
            figures = None
        now = CompareRow(CURRENT, name, "current", rig, "", result.evaluation.scores, figures)
        self._rows = {CURRENT: now} | {key: row for key, row in self._rows.items() if key != CURRENT}
        self._ask()

    def take_count(self, answer: CountAnswer) -> None:
        """Store the counts of a rig; another way of counting discards all other counts."""
        request, before = answer.request, self._counted
        self._counted = request, answer.figures
        if before is None or not _are_counted_alike(before[0], request):
            self._drop_figures()
        now = self._rows.get(CURRENT)
        if now is not None and now.rig == request.rig:
            self._rows[CURRENT] = replace(now, counted=answer.figures)
        self._ask()

    def drop_scores(self, scene: LoadedScene | None) -> None:
        """Discard all scores, and all counts of other traffic than the current one."""
        self._scored_on = None
        self._rows = {key: replace(row, scores=None) for key, row in self._rows.items()}
        if self._counted is not None and (scene is None or self._counted[0].options is not scene.options):
            self._counted = None
            self._drop_figures()
        self._forget()
        self.changed.emit()

    def _drop_figures(self) -> None:
        self._rows = {key: replace(row, counted=None) for key, row in self._rows.items()}
        self._counter.drop_group(GROUP)
        self._asked_counts.clear()

    def _forget(self) -> None:
        self._recompute.drop_group(GROUP)
        self._asked.clear()
        self._counter.drop_group(GROUP)
        self._asked_counts.clear()

    # ------------------------------------------------------------------ asking for the others
    def _ask(self) -> None:
        """Request the missing numbers, once the traffic and the settings are known."""
        self._take_meshes()
        if self._scored_on is not None and not self.is_given_up:
            scene, settings = self._scored_on
            new = [row for row in self.missing if row.key not in self._asked]
            self._asked.update(row.key for row in new)
            self._recompute.ask_in_background(
                [ScoreRequest(GROUP, row.key, row.rig, settings, scene) for row in new]
            )
        if self._counted is not None and not self.is_given_up:
            self._ask_counts(self._counted[0])
        self.changed.emit()

    def _take_meshes(self) -> None:
        """Attach the meshes that have been read to the other rigs; figures computed without one are dropped."""
        for key, row in list(self._rows.items()):
            rig = self._session.with_mesh(row.rig)
            if rig is not row.rig and key != CURRENT:
                self._rows[key] = replace(row, rig=rig, scores=None, counted=None)
                self._asked.discard(key)
                self._asked_counts.discard(key)

    def _ask_counts(self, counted: CountRequest) -> None:
        """Request the counts of the other rigs; a mesh that was not read is not used for them."""
        new = [
            row
            for row in self._rows.values()
            if row.counted is None and row.key != CURRENT and row.key not in self._asked_counts
        ]
        self._asked_counts.update(row.key for row in new)
        self._counter.ask_in_background(
            [OtherCount(GROUP, row.key, row.rig, counted.settings, counted.options) for row in new]
        )

    def _take_count(self, request: OtherCount, figures: Values | None) -> None:
        counted = self._counted
        row = self._rows.get(request.name) if request.group == GROUP else None
        if row is None or counted is None or row.rig is not request.rig:
            return
        if _are_counted_alike(request, counted[0]):
            self._rows[row.key] = replace(row, counted=figures or {})
            self.changed.emit()

    def _take(self, request: BackgroundRequest, scores: Scores | None) -> None:
        if not isinstance(request, ScoreRequest) or request.group != GROUP:
            return
        row, scored_on = self._rows.get(request.name), (request.scene, request.settings)
        if row is not None and row.rig is request.rig and scored_on == self._scored_on:
            self._rows[row.key] = replace(row, scores=scores)
            self.changed.emit()


def _are_counted_alike(one: CountRequest | OtherCount, other: CountRequest) -> bool:
    """Return whether figures have in common what figures side by side must: the traffic and the counting settings."""
    return one.options is other.options and one.settings == other.settings
