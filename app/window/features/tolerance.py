"""Show the spread of figures under mount errors: measured while no edit runs, once a profile is chosen."""

from __future__ import annotations

from dataclasses import replace
from math import floor, log10
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from riglens.app.background.background_requests import ToleranceProgress, ToleranceRequest
from riglens.app.background.queue import BackgroundRequest
from riglens.app.window.feature import Feature
from riglens.app.window.features.checks import add_check, check_spec
from riglens.app.window.features.targets import Targets
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.figures.coverage import SEEN
from riglens.core.review.tolerance import (
    PROFILES,
    Spread,
    ToleranceProfile,
    ToleranceResult,
    chance_bounds,
    is_less_better,
    profile_called,
    worst_rig,
)
from riglens.core.rig.model import Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.widgets.panels.checks.tolerance import WAITING, Below, Range, TolerancePanel

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.review.requirements import Requirements

DRAWS = 64
"""Number of draws, as many as `riglens review` takes by default."""
GROUP = "tolerance"
SEEN_FROM_M, SEEN_FROM_DEG = 0.15, 8.0
"""Size to which errors in the view are magnified: millimetres are invisible on a car."""


class Tolerance(Feature):
    """Tolerance strip: nothing is drawn until a profile is chosen. An edit cancels the measurement, which restarts at
    rest."""

    specs = (check_spec("tolerances", "Tolerance", "Show the spread of figures under mount errors."),)

    def __init__(self, bench: Workbench, targets: Targets) -> None:
        super().__init__(bench)
        self._targets = targets
        self.strip = TolerancePanel(tuple(CLASSES), [profile.name for profile in PROFILES])
        self.profile: ToleranceProfile | None = None
        self.answer: ToleranceProgress | None = None
        self._asked: ToleranceRequest | None = None
        self._required: Requirements | None = None
        add_check(bench, "tolerances", self.strip)
        self.strip.profile_chosen.connect(self.choose)
        self.strip.figure_chosen.connect(lambda _: self._show())
        self.strip.ghost_wanted.connect(lambda _: self._show_ghost())
        self.strip.requirements_wanted.connect(bench.guarded(self._choose_requirements))
        bench.recompute.answered_in_background.connect(self._take, Qt.ConnectionType.QueuedConnection)
        self.session.heat_changed.connect(self._show_ghost)
        for changed in (bench.answers.answered, self.document.rig_settled, targets.counted):
            changed.connect(lambda *_: self._ask())
        bench.theme_changed.connect(lambda _: self._show())
        self.remember("tolerance/figure", lambda: self.strip.figure, self.strip.choose)
        self.remember(
            "tolerance/profile", lambda: "" if self.profile is None else self.profile.name, self._take_profile
        )

    # ------------------------------------------------------------------ the choice
    def choose(self, name: str) -> None:
        """Draw errors of a profile, or none with an empty name; InputError for one that there is not."""
        before, self.profile = self.profile, profile_called(name) if name else None
        if before is None and self.profile is not None:  # no drag is to wake who waits for nothing
            self.session.request_changed.connect(self._drop_if_changed)
        elif before is not None and self.profile is None:
            self.session.request_changed.disconnect(self._drop_if_changed)
        self.strip.show_profile(name)
        self.forget_scene()
        self._ask()

    def _choose_requirements(self) -> None:
        """Load the limits of a file, as for `riglens check`, or drop the current ones; InputError for a file without
        requirements on these figures."""
        if self._required is not None:
            self._required = None
            self.strip.show_required("")
        else:
            path = self.bench.dialogs.requirements_file(self.bench.window, self.document.folder)
            if path is None:
                return
            self._required = requirements_of_figures(path)
            self.strip.show_required(path.name)
        self._show()

    def _take_profile(self, name: str) -> None:
        try:
            self.choose(name)
        except InputError:  # of another version of the program
            self.choose("")

    # ------------------------------------------------------------------ asking
    def _request(self) -> ToleranceRequest | None:
        """Return the measurement to request for the current view, None if none is needed."""
        result, session = self.bench.answers.result, self.session
        if self.profile is None or result is None or session.scene is None:
            return None
        count, settings = self._targets.answer_on_scene, replace(session.settings, body=session.body)
        traffic = None if count is None else count.traffic
        return ToleranceRequest(
            GROUP, "", session.working_rig, settings, session.scene, profile=self.profile,
            draws=DRAWS, targets=session.targets, traffic=traffic,
        )  # fmt: skip

    def _ask(self) -> None:
        """Request a measurement once the mouse rests and the scores exist, unless it is the same."""
        if self.document.is_dragging or not self.bench.answers.is_current:
            return
        request = self._request()
        if request is None or request == self._asked:
            return
        self._asked = request
        self._grey()
        self.bench.recompute.ask_in_background([request])

    def _drop_if_changed(self) -> None:
        """Discard results of another rig or of other settings."""
        if self._asked is not None and self._request() != self._asked:
            self.forget_scene()

    def forget_scene(self) -> None:
        """Forget the request and its answer: other traffic, or another rig."""
        self.bench.recompute.drop_group(GROUP)
        self._asked = self.answer = None
        self._grey()
        self._show_ghost()

    def _grey(self) -> None:
        if self.profile is not None:
            self.strip.grey(f"{self.profile.name}: {WAITING}")

    # ------------------------------------------------------------------ showing
    def _take(self, request: BackgroundRequest, answer: ToleranceProgress | None) -> None:
        if request is self._asked and answer is not None and answer.result is not None:
            self.answer = answer
            self._show()

    def _show(self) -> None:
        answer = self.answer
        if answer is not None and answer.result is not None:
            found, spreads = answer.result, answer.result.spreads
            ranges = {
                name: range_of(
                    spreads[key],
                    found.floor[key],
                    below_of(spreads[key], self._required, found.profile, self.strip.figure, name),
                )
                for name in CLASSES
                if (key := f"{self.strip.figure} {name}") in spreads
            }
            self.strip.show_ranges(ranges, head_of(answer), tip_of(found))
        self._show_ghost()

    def _show_ghost(self) -> None:
        """Show the rig of the worst draw by the figure and the class shown, its errors magnified to be seen."""
        answer, note = self.answer, ""
        ghosts: tuple[Sensor, ...] = ()
        key = f"{self.strip.figure} {self.session.heat.class_name}"
        if self.strip.worst.isChecked() and answer is not None and answer.result is not None:
            found = answer.result
            if key in found.spreads:
                times = magnified(found.profile)
                ghosts = worst_rig(found, key, times).sensors
                draw = found.spreads[key].worst_draw
                note = f"worst by {key.replace('_', ' ')}: draw {draw}, errors × {times:g}"
        self.strip.ghost_note.setText(note)
        if ghosts != self.viewport.state.ghosts:
            self.viewport.show_state(replace(self.viewport.state, ghosts=ghosts))


def head_of(answer: ToleranceProgress) -> str:
    """Return the heading of a spread: its rig, and the number of draws so far."""
    assert answer.result is not None
    drawn = len(next(iter(answer.result.spreads.values())).values)
    share = "" if answer.is_whole else f", {100 * answer.done // answer.steps} %"
    return f"{answer.result.profile.name}: {drawn} draws plus the rig as designed{share}"


def tip_of(found: ToleranceResult) -> str:
    """Return all figures in full, and the command that computes the same."""
    lines = [
        f"{name.replace('_', ' ')}: {100 * s.nominal:.3f} % as designed, median {100 * s.median:.3f} %, "
        f"5 to 95 % {100 * s.p05:.3f} to {100 * s.p95:.3f} %, worst {100 * s.worst:.3f} % (draw {s.worst_draw})"
        for name, s in found.spreads.items()
    ]
    how = f"riglens review RIG --only tolerance --errors {found.profile.name} --draws {found.draws}"
    said = [found.sample_text] if found.sample_text else []
    return "\n".join([*lines, *said, f"{found.profile.name} is {found.profile.source}.", f"As {how}"])


def requirements_of_figures(path: Path) -> Requirements:
    """Return the requirements on figures that have tolerances; InputError if there are none or the file cannot be
    read."""
    from riglens.core.review.requirements import read_requirements

    found = read_requirements(path)
    if not (found.tolerance or found.seen or found.limits):
        raise InputError(f"{path}: needs a section 'tolerance', 'figures', 'seen' or 'on_target'")
    return found


def below_of(
    spread: Spread, required: Requirements | None, profile: ToleranceProfile, figure: str, cls: str
) -> Below | None:
    """Return the number of draws that are worse than the required figure of a class, preferably that required under the
    profile."""
    if required is None:
        return None
    is_less = is_less_better(figure)
    for asked in required.tolerance:
        if (asked.figure, asked.cls) == (figure, cls) and required.errors[asked.profile] == profile:
            return _below(spread, asked.limit, asked.at_most, is_less)
    limits = [
        one.accepted
        for one in required.limits
        if (one.figure, one.cls, one.ring_m, one.sector) == (figure, cls, None, None)
        and (one.relation == "at most") == is_less
    ]
    if figure == SEEN.key:
        limits += [one.at_least for one in required.seen if one.cls == cls and one.by == "any"]
    return _below(spread, (min if is_less else max)(limits), None, is_less) if limits else None


def _below(spread: Spread, limit: float, at_most: float | None, is_less: bool) -> Below:
    worse = [value > limit if is_less else value < limit for value in spread.values]
    below, draws = sum(worse), len(worse)
    low, high = chance_bounds(below, draws)
    return Below(
        100.0 * limit,
        100.0 * below / draws,
        100.0 * low,
        100.0 * high,
        None if at_most is None else 100.0 * at_most,
    )


def range_of(spread: Spread, floor_spread: Spread, below: Below | None = None) -> Range:
    """Return a spread in percentage points next to the rig as designed."""
    low, high, median, worst = (
        100.0 * (value - spread.nominal) for value in (spread.p05, spread.p95, spread.median, spread.worst)
    )
    noise_low, noise_high = (
        100.0 * (value - spread.nominal) for value in (floor_spread.p05, floor_spread.p95)
    )
    return Range(low, high, median, worst, noise_low, noise_high, below)


def magnified(profile: ToleranceProfile) -> float:
    """Return the round factor, at least 1, that makes errors at the profile's limits visible in the view."""
    shift_m = max(profile.position_mm, profile.bracket_position_mm, profile.car_heave_mm) / 1e3
    turn_deg = max(profile.angle_deg, profile.bracket_angle_deg, profile.car_roll_deg, profile.car_pitch_deg)
    limits = ((SEEN_FROM_M, shift_m), (SEEN_FROM_DEG, turn_deg))
    times = min((wanted / limit for wanted, limit in limits if limit), default=1.0)
    power = 10.0 ** floor(log10(max(times, 1.0)))
    return power * max(step for step in (1.0, 2.0, 5.0) if step * power <= max(times, 1.0))
