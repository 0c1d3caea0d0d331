"""Propose rigs in a process of its own while the window goes on; look at them as ghosts, compare and apply them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args, get_type_hints

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo
from PySide6.QtCore import Qt, Signal

from riglens.app.background.proposing import (
    Answer,
    ProposalRequest,
    Proposer,
    SearchEnd,
    SearchProgress,
    SearchWork,
)
from riglens.app.window.actions import Spec
from riglens.app.window.docks import InSight
from riglens.app.window.feature import Feature
from riglens.app.window.features.compare import Compare
from riglens.app.window.features.files import beside_rig
from riglens.app.window.features.sensors import follow_marks, hold_of
from riglens.app.window.status import TOLD_MS
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.figures.text import value_text
from riglens.core.optimise.objectives import Objective, objective_named, objectives
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensors.lidar import LIDAR
from riglens.evaluation.names import label_of
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.requests import fixed_options
from riglens.evaluation.search_options import SearchOptions
from riglens.widgets.panels.controls.scrolled import scrolled
from riglens.widgets.panels.propose.panel import ProposePanel
from riglens.widgets.panels.propose.shown import (
    NO_SEARCH,
    RUNNING,
    Bracket,
    Offer,
    bracket_plot,
    check_cells,
    front_plot,
    offers_of,
    sentence_of,
    verdict_of,
)
from riglens.widgets.timers import Timers, single_shot

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.optimise.results import OptimiseResult

DOCK = "Propose"
STOP_MS = 400
"""A search that has not ended by then after Stop is ended with its process."""
NO_DATA = "no box data are loaded: choose some in the Scene panel"
NO_BOXES = "a stored POG holds no objects: load the box data set to search"
CHANGED = "The rig has been edited since."
USUAL = SearchOptions(("velodyne-vlp-16",))
IN_SIGHT = ("count", "objective")
"""Options beside the models to add."""
MORE = (
    ("singles", "budget", "blind_m", "cost", "weight"),
    ("frames", "spots_m", "lowest_m", "spacing_m", "beyond_m"),
    ("yaw_deg", "tilt_deg"),
)
"""Further options, side by side."""


def fields_of(names: Sequence[str]) -> dict[str, FieldInfo]:
    """Return fields of the options with the words of the window."""
    hints, found = get_type_hints(SearchOptions, include_extras=True), dict[str, FieldInfo]()
    choices = {"objective": {one.key: one.title for one in objectives().values()}}
    for name in names:
        kind, said = get_args(hints[name])
        titles: dict[str, Any] | None = None
        if name in choices:
            kind, titles = Literal[tuple(choices[name])], {"titles": choices[name]}
        tip = said.help if titles is None else "Figure to improve."
        tip = tip.replace("; may be repeated", "")  # by words that the field takes together
        found[name] = FieldInfo(
            annotation=kind, title=label_of(name), description=tip, json_schema_extra=titles
        )
    return found


class KeptSearch(NamedTuple):
    """A search of the session, with what it has found."""

    asked: ProposalRequest
    result: OptimiseResult
    history: list[Bracket]

    @property
    def title(self) -> str:
        """Name the search."""
        options = self.asked.options
        if self.asked.work == "improve":
            return f"{self.asked.number}: better mount of {self.asked.sensor}"
        what = "sensor" if options.singles else "pair"
        some = f"{options.count} {what}{'s' * (options.count > 1)}"
        return f"{self.asked.number}: {some} of {', '.join(options.add)}"


class Propose(Feature):
    """Latest requested search and its result; later edits do not affect it."""

    specs = (
        Spec(
            "improve", "Improve this sensor",
            "Search for a better mount of the selected LiDAR on the skin near where it is.", menu="sensor/place",
        ),
    )  # fmt: skip

    begun = Signal()
    """The process keeps no gains of an earlier search any more."""

    def __init__(
        self,
        bench: Workbench,
        compare: Compare,
        proposer: Proposer | None = None,
        timers: Timers = single_shot,
    ) -> None:
        super().__init__(bench)
        self._compare = compare
        self.panel = ProposePanel(USUAL, fields_of(IN_SIGHT), [fields_of(names) for names in MORE])
        self.proposer = proposer or Proposer(self)
        self.result: OptimiseResult | None = None
        """The result that is shown; its traffic stays in the process."""
        self._asked: ProposalRequest | None = None
        self._is_running, self._number = False, 0
        self._history: list[Bracket] = []
        self._offers: dict[str, Offer] = {}
        self._kept: list[KeptSearch] = []
        self._too_long = timers(self, STOP_MS, self._end)
        dock = bench.docks.add(
            DOCK, scrolled(self.panel), Qt.DockWidgetArea.BottomDockWidgetArea, beside="Scores"
        )
        self.in_sight = InSight(dock)
        self._connect()

    def _connect(self) -> None:
        panel, bench, queued = self.panel, self.bench, Qt.ConnectionType.QueuedConnection
        panel.start_wanted.connect(bench.guarded(self.start))
        panel.pause_wanted.connect(self.pause)
        panel.stop_wanted.connect(self.stop)
        panel.hovered.connect(self._show_ghosts)
        panel.selected.connect(self._show_ghosts)
        panel.chosen.connect(self._choose)
        panel.apply_wanted.connect(bench.guarded(self.apply))
        panel.compare_wanted.connect(lambda _: bench.docks.bring_up("Compare"))
        panel.search_chosen.connect(self._show_again)
        panel.export_wanted.connect(bench.guarded(self.export))
        self.proposer.answered.connect(self._take, queued)
        self.proposer.failed.connect(self._fail, queued)
        self.in_sight.changed.connect(self._turn)
        self.document.rig_settled.connect(self._show_sentence)
        bench.theme_changed.connect(lambda _: panel.plots.update())
        self.bind(improve=bench.guarded(self.improve))
        bench.panels.tree.menu_wanted.connect(lambda menu: menu.addAction(self.actions["improve"]))
        follow_marks(self.document, self._update)
        bench.closing.connect(self.proposer.end)
        self.remember("propose/options", lambda: asdict(panel.options), self._take_options)

    def _turn(self, _: bool) -> None:
        """Show no ghosts until the mouse is over an offer again."""
        self._show_ghosts("")

    def _take_options(self, kept: dict[str, Any]) -> None:
        """Take the options of an earlier session; what no longer exists is left out."""
        known = {entry.name for entry in default_library().entries()}
        with suppress(ValidationError, InputError):  # options of another version, or edited by hand
            options = TypeAdapter(SearchOptions).validate_python(kept)
            self.panel.show_options(options.replace(add=tuple(one for one in options.add if one in known)))

    # ------------------------------------------------------------------ the search
    def start(self) -> None:
        """Begin a search for the current rig; raise InputError without objects or models."""
        if not self.panel.models:
            raise InputError("choose at least one sensor model to add")
        self._ask("add", self.panel.options)

    def improve(self) -> None:
        """Begin a search for a better mount of the selected sensor."""
        name = self.document.selected
        assert name is not None
        self.bench.docks.bring_up(DOCK)
        self._ask("improve", sensor=name)

    def find_gains(self) -> None:
        """Begin to cast what `start` would, for the gains alone; a search under way brings them anyway."""
        if not self._is_running:
            self._ask("skin", self.panel.options)

    def _scene(self) -> SceneOptions:
        scene = self.session.scene
        if scene is None:
            raise InputError(NO_DATA)
        if scene.options.pog is not None:
            raise InputError(NO_BOXES)
        return fixed_options(scene)

    @property
    def objective(self) -> str:
        """Return the title of the figure that the last search maximised."""
        return self._goal.title

    @property
    def _goal(self) -> Objective:
        return objective_named((USUAL if self._asked is None else self._asked.options).objective)

    def _ask(self, work: SearchWork, options: SearchOptions = SearchOptions(), sensor: str = "") -> None:
        number = self._number + 1
        request = ProposalRequest(number, work, self.session.rig, self._scene(), options, sensor)
        if work != "improve":
            self.begun.emit()
        self._forget_result()
        self._asked, self._number, self._is_running = request, number, True
        self.proposer.send(request)
        self.panel.show_state("running")
        self.panel.show_progress("Loading", 0.0)
        self.panel.show_sentence(RUNNING)
        self._show()

    def pause(self, is_wanted: bool) -> None:
        """Pause the search, or go on with it."""
        if self._is_running:
            self.proposer.send("pause" if is_wanted else "go on")
            self.panel.show_state("paused" if is_wanted else "running")

    def stop(self) -> None:
        """End the search; what it has found stays."""
        if self._is_running:
            self.proposer.send("stop")
            self._too_long.start()

    def _end(self) -> None:
        """End a search that takes too long to stop."""
        if self._is_running:
            self.begun.emit()
            self.proposer.end()
            self._rest()

    def _rest(self) -> None:
        self._is_running = False
        self._too_long.stop()
        self.panel.show_state("idle")
        if self.panel.sentence.text() == RUNNING:
            self._show_sentence()

    def _take(self, answer: Answer) -> None:
        if answer.number != self._number or not self._is_running:
            return
        if isinstance(answer, SearchProgress):
            self._take_progress(answer)
        elif isinstance(answer, SearchEnd):
            self._rest()
            if answer.problem:
                self.bench.report_error(answer.problem)
            elif answer.result is not None:
                self._take_result(answer.result)
            self._keep_result()

    def _keep_result(self) -> None:
        """Keep what has been found for the session."""
        if self.result is not None and self._asked is not None:
            self._kept.append(KeptSearch(self._asked, self.result, self._history))
            self.panel.show_searches([one.title for one in self._kept])

    def _show_again(self, place: int) -> None:
        """Show an earlier search."""
        self._asked, self.result, self._history = self._kept[place]
        self._show()

    def _take_result(self, found: OptimiseResult) -> None:
        is_first, self.result = self.result is None, found
        self._show()
        if is_first and self._asked is not None and self._asked.work == "improve":
            self.panel.select("proposal 1")

    def _take_progress(self, answer: SearchProgress) -> None:
        self.panel.show_progress(answer.stage.capitalize(), answer.share)
        self._history.append((answer.elapsed_s, answer.value, answer.bound))
        if answer.result is not None:
            self._take_result(answer.result)
            return
        self._show_plots()
        if answer.best is not None and self._asked is not None:
            now, best = (
                Offer("", "Now", self._asked.rig),
                Offer("best", "Best found", answer.best, answer.value),
            )
            self.panel.show_offers((now, best), self._goal.figure)
            self._keep((now, best))
        if answer.value is not None and answer.bound is not None:
            figure = self._goal.figure
            values = f"{self.objective} {value_text(figure, answer.value)} so far"
            beyond = f"{'below' if figure.better == 'less' else 'above'} {value_text(figure, answer.bound)}"
            where = " in these frames" if self._goal.of_objects else ""
            self.panel.show_sentence(f"{values}; no allowed set is {beyond}{where}.")

    def _fail(self, line: str) -> None:
        self.begun.emit()
        if self._is_running:
            self._rest()
        self.bench.report_error(f"Propose: {line}")

    def forget_scene(self) -> None:
        """Forget everything: other traffic."""
        self.begun.emit()
        self.proposer.end()
        self._rest()
        self._asked = None
        self._kept = []
        self.panel.show_searches([])
        self._forget_result()
        self._show()

    def _forget_result(self) -> None:
        self.result, self._history, self._offers = None, [], {}

    # ------------------------------------------------------------------ showing
    def _show(self) -> None:
        """Show the result, or that there is none."""
        found, panel = self.result, self.panel
        rows = [] if found is None else offers_of(found)
        panel.show_offers(rows, self._goal.figure)
        self._keep(rows)
        self._show_plots()
        panel.show_checks(*check_cells(found), "" if found is None else verdict_of(found))
        self._show_sentence()
        self._show_ghosts(panel.plots.key)

    def _show_plots(self) -> None:
        """Show the charts that belong to what was asked for."""
        plots, asked = [bracket_plot(self._history)], self._asked
        if asked is not None and asked.options.blind_m is not None:
            plots.append(front_plot(self.result))
        self.panel.show_plots(plots)

    def _keep(self, offers: Sequence[Offer]) -> None:
        self._offers = {one.key: one for one in offers if one.key}
        if self.panel.key not in self._offers:
            self.panel.select("")

    def _show_sentence(self) -> None:
        if self.result is not None and self._asked is not None:
            is_same = self._asked.rig.sensors == self.session.rig.sensors
            self.panel.show_sentence(" ".join([sentence_of(self.result), *([] if is_same else [CHANGED])]))
        elif not self._is_running:
            self.panel.show_sentence(NO_SEARCH)

    def _changes(self, key: str) -> tuple[Sensor, ...]:
        """Return the sensors of an offer that the rig of the search does not have like this."""
        offer, asked = self._offers.get(key), self._asked
        if offer is None or asked is None:
            return ()
        return tuple(sensor for sensor in offer.rig.sensors if sensor not in asked.rig.sensors)

    def _show_ghosts(self, key: str) -> None:
        """Show the sensors of the offer under the mouse, else of the chosen one; none while out of sight."""
        ghosts = self._changes(key or self.panel.key) if self.in_sight else ()
        if ghosts != self.viewport.state.ghosts:
            self.viewport.show_state(replace(self.viewport.state, ghosts=ghosts))

    def _update(self) -> None:
        document = self.document
        is_one = len(document.chosen) == 1 and document.rig.sensor(document.chosen[0]).kind == LIDAR.name
        self.actions.allow("improve", hold_of(document) or ("" if is_one else "Select one LiDAR only."))

    # ------------------------------------------------------------------ what is done with an offer
    def _choose(self, key: str) -> None:
        """List an offer in the Compare panel next to the rig."""
        if key in self._offers:
            self._compare.add_rig(self._offers[key].title, self._offers[key].rig)

    def apply(self, key: str) -> None:
        """Make the changes of an offer to the current rig, as one step; raise InputError where they collide."""
        offer, asked = self._offers[key], self._asked
        assert asked is not None
        rig = merged(self.document.rig, asked.rig, self._changes(key))
        self.document.apply(rig, f"apply {offer.title.lower()}")
        self._show_ghosts("")

    def export(self) -> None:
        """Write rigs and figures of all proposals into a folder."""
        suggestion = beside_rig(self.document, "proposals", "")
        chosen = self.bench.dialogs.export_rig(self.bench.window, suggestion, "proposals", True)
        if chosen is not None and self.result is not None:
            self.result.save(chosen)
            self.bench.status.showMessage(f"Proposals written: {chosen}", TOLD_MS)

    def why(self) -> dict[str, Any] | None:
        """Return the reasons for the rig's proposed sensors, for a report; None if it has no proposed sensor."""
        found, names = self.result, {sensor.name: sensor for sensor in self.document.rig.sensors}
        if found is None:
            return None
        applied = [sensor.name for sensor in self._changes("proposal 1") if names.get(sensor.name) == sensor]
        if not applied or len(applied) < len(self._changes("proposal 1")):
            return None
        return {
            "figure": found.problem.objective,
            "sensors": applied,
            "sentence": sentence_of(found),
            "reference": found.reference.name,
            "verdict": found.best.verdict,
            "checks": [
                {"case": one.case, "gain": one.gain, "se": one.se, "share": one.share}
                for one in found.best.guard
            ],
        }


def merged(rig: Rig, base: Rig, changes: Sequence[Sensor]) -> Rig:
    """Return a rig with changes that were made to an earlier state of it; raise InputError where they collide."""
    before = {sensor.name for sensor in base.sensors}
    sensors = {sensor.name: sensor for sensor in rig.sensors}
    for sensor in changes:
        if (sensor.name in before) != (sensor.name in sensors):
            said = "no longer" if sensor.name in before else "already"
            raise InputError(f"'{sensor.name}' is {said} in the rig")
        sensors[sensor.name] = sensor
    return rig.replace(sensors=tuple(sensors.values()))
