"""Detection range of the rig being edited: computed when the mouse rests and the page is visible, else grey."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import Any

from PySide6.QtCore import Qt

from riglens.app.background.rig_questions import RigRequest, detection_range
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.feature import Feature
from riglens.app.window.features.checks import add_check, check_spec
from riglens.app.window.features.files import beside_rig
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.targets.detection_range import USUAL_PLAN, DetectionRange, RangePlan
from riglens.core.targets.detection_range_table import range_lines
from riglens.studies.files import csv_text
from riglens.widgets.panels.detection_range.panel import RangePanel

KEPT = {
    "min_points": int,
    "min_height_px": float,
    "to_m": float,
    "reaction_s": float,
    "deceleration_mps2": float,
}
"""Settings of the plan that are kept between sessions."""
NOW = (
    "{name}, current{failed}, body {body}: detection range in metres; LiDARs: worst-median-best position between "
    "the beams; more is better"
)
BEFORE = "Out of date: {name} before the last change"
WAITS, MOVES, MAKING = "after the first scores", "while a sensor moves", "computing detection ranges"
STOPPED = "stopped"


RangeRequest = RigRequest[RangePlan]


class DetectionRangeShown(Feature):
    """A page that costs nothing while it is out of sight."""

    specs = (
        check_spec(
            "detection_range",
            "Detection range",
            "Show the detection range by class and direction.",
        ),
    )

    def __init__(
        self, bench: Workbench, maker: BackgroundWorker[RangeRequest, DetectionRange] | None = None
    ) -> None:
        super().__init__(bench)
        self.maker = maker or BackgroundWorker("detection range", detection_range, self)
        self.panel, self._plan = RangePanel(USUAL_PLAN), USUAL_PLAN
        self._asked: RangeRequest | None = None
        self._answer: tuple[RangeRequest, DetectionRange] | None = None
        self._ended: tuple[RangeRequest, str] | None = None
        """The request that was stopped or failed, and why it has no answer."""
        self._shown: tuple[DetectionRange, bool] | None = None
        self.in_sight = add_check(bench, "detection_range", self.panel)
        self.in_sight.follow(
            self._follow, self.session.request_changed, self.document.rig_settled, bench.answers.answered
        )
        self.serve(self.maker, self._take, self._end)
        self.maker.progressed.connect(self._on_progress, Qt.ConnectionType.QueuedConnection)
        self.panel.plan_wanted.connect(self._choose)
        self.panel.stop_wanted.connect(lambda: self._end(STOPPED))
        self.panel.make_wanted.connect(self._make)
        self.panel.export_wanted.connect(bench.guarded(self._export))
        bench.theme_changed.connect(lambda _: self._show_anew())
        self.remember(
            "detection_range/plan",
            lambda: {name: getattr(self._plan, name) for name in KEPT},
            self._take_plan,
        )

    # ------------------------------------------------------------------ asking
    @property
    def _wanted(self) -> RangeRequest:
        """Return the request for the current rig; the braking model does not affect the counts."""
        session = self.session
        plan = self._plan.braking_as(USUAL_PLAN).with_body(session.solid_body)
        return RigRequest(session.working_rig, plan)

    @property
    def is_current(self) -> bool:
        """Return whether the shown results belong to the current rig."""
        return self._answer is not None and self._answer[0] == self._wanted

    def _follow(self, *_: object) -> None:
        """Request the results of the current rig, once the mouse rests, unless they exist or are on their way."""
        wanted = self._wanted
        if self._asked is not None and self._asked != wanted:
            self.maker.drop()
            self._asked = None
        rests = not self.document.is_dragging and self.bench.answers.result is not None
        is_over = self._ended is not None and self._ended[0] == wanted
        if rests and self._asked is None and not is_over and not self.is_current:
            self._asked, self._ended = wanted, None
            self.maker.ask(wanted)
            self.panel.show_progress(0.0)
        self._show()

    def _make(self) -> None:
        """Request ranges again that were stopped or failed."""
        self._ended = None
        self._follow()

    def _end(self, reason: str) -> None:
        """Leave it at that."""
        if self._asked is not None:
            self.maker.drop()
            self._ended = self._asked, reason
            self._asked = None
            self._show()

    def _choose(self, plan: RangePlan) -> None:
        self._plan = plan
        self.panel.show_plan(plan)
        self._show_anew()
        if self.in_sight:
            self._follow()

    # ------------------------------------------------------------------ what comes back
    def _take(self, request: RangeRequest, ranges: DetectionRange) -> None:
        self._answer = request, ranges
        if request is self._asked:
            self._asked = None
        self._show()

    def _on_progress(self, request: RangeRequest, share: float) -> None:
        if request is self._asked:
            self.panel.show_progress(share)

    # ------------------------------------------------------------------ showing
    def _show_anew(self) -> None:
        self._shown = None
        self._show()

    def _show(self) -> None:
        """Show the ranges, their rig, and whether newer ones are being computed."""
        if self._answer is not None:
            ranges, is_current = self._answer[1], self.is_current
            ranges = replace(ranges, plan=ranges.plan.braking_as(self._plan))
            if self._shown != (ranges, is_current):
                self._shown = ranges, is_current
                self.panel.show_range(ranges)
                self.panel.show_current(is_current)
        if self._asked is None:
            self.panel.show_progress(None, can_make=self._ended is not None and not self.is_current)
        self.panel.say(self._words())

    def _words(self) -> str:
        if self._answer is not None and self.is_current:
            failed = ", without failed sensors" if self.document.failed else ""
            return NOW.format(name=self._answer[0].rig.name, failed=failed, body=self.session.solid_body)
        if self._asked is not None:
            why = MAKING
        elif self.document.is_dragging:
            why = MOVES
        else:
            why = WAITS if self._ended is None else self._ended[1]
        before = "No results yet" if self._answer is None else BEFORE.format(name=self._answer[0].rig.name)
        return f"{before} ({why})"

    # ------------------------------------------------------------------ between sessions, export
    def _take_plan(self, kept: dict[str, Any]) -> None:
        """Take the thresholds and the braking model of an earlier session."""
        numbers: dict[str, Any] = {
            name: kept[name] for name, kind in KEPT.items() if type(kept.get(name)) is kind
        }
        with suppress(InputError):
            self._choose(RangePlan(**numbers))

    def _export(self) -> None:
        if self._shown is None or not self.is_current:
            return
        ranges = self._shown[0]
        path = self.bench.dialogs.save_table(self.bench.window, beside_rig(self.document, "range", ".csv"))
        if path is not None:
            write_file(path, csv_text(range_lines(ranges)))
