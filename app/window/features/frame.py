"""Show one frame of the traffic in the 3D view: plain bodies for scale, or one that is chosen, with the points on its
objects, following every drag; and step through the missed objects."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Signal

from riglens.app.background.counting import CountAnswer, CountRequest
from riglens.app.background.frames import FrameAnswer, FrameCasting, FrameRequest
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.targets import Targets
from riglens.app.window.workbench import Workbench
from riglens.core.kernels.runtime.codes import BODY, GROUND
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.widgets.timers import Timers, single_shot
from riglens.widgets.traffic.frame import ShownFrame, plain_frame

if TYPE_CHECKING:
    from riglens.core.targets.traffic import Traffic
    from riglens.core.view.frame_scene import FrameScene, Missed

FRAME_MS = 200
"""Shortest time for which each frame is shown during playback."""
NONE_MISSED = "The rig misses no object in the frames counted so far"


class _Shown(NamedTuple):
    """Content of the view: the frame's index in the traffic, and the number of a box there that is explained."""

    place: int
    explain: int | None


class FrameView(Feature):
    """View of a frame, empty and without cost until a frame is chosen in the Targets panel."""

    specs = (
        Spec(
            "show_frame", "Show a frame of the traffic", "Show the objects of one frame, coloured by LiDAR points.",
            "Shift+T", menu="scene/frames", is_checkable=True,
        ),
        Spec(
            "next_missed", "Next missed object", "Fly to the next object that no sensor detects.",
            "Ctrl+J", menu="scene/frames",
        ),
        Spec(
            "play_frames", "Play frames", "Play back traffic frames.", "Shift+J",
            menu="scene/frames", is_checkable=True,
        ),
        Spec(
            "plain_traffic", "Plain traffic",
            "Show the objects of a typical frame as plain bodies while no frame is chosen.", "Shift+P",
            menu="scene/frames", is_checkable=True,
        ),
    )  # fmt: skip

    frame_chosen = Signal(int)
    """Another frame is shown, by its number in the data."""
    drawn = Signal()
    """The view shows another frame, or the same with other points, or none any more."""

    def __init__(
        self,
        bench: Workbench,
        targets: Targets,
        caster: BackgroundWorker[FrameRequest, FrameAnswer] | None = None,
        timers: Timers = single_shot,
    ) -> None:
        super().__init__(bench)
        self._targets = targets
        self.caster = caster or BackgroundWorker("frame view", FrameCasting(), self)
        self._shown: _Shown | None = None
        self._last: FrameRequest | None = None
        self._asked: FrameRequest | None = None
        """The last request until it is answered."""
        self._missed: tuple[CountRequest, int] | None = None
        """Missed object that was shown last, and the count at that time."""
        panel = targets.panel
        panel.frame_wanted.connect(self._choose)
        panel.next_missed_wanted.connect(self.show_next_missed)
        panel.play_wanted.connect(self.play)
        self._plain: ShownFrame | None = None
        """Bodies of the scene's typical frame, once its objects have been counted."""
        self._is_playing, self._next = False, timers(self, FRAME_MS, self._show_next)
        self.bind(
            show_frame=lambda: self._choose(0 if self._shown is None else None),
            next_missed=self.show_next_missed,
            play_frames=lambda: self.play(not self._is_playing),
            plain_traffic=self._show_plain,
        )
        self.actions["plain_traffic"].setChecked(True)
        self.remember(
            "frame/plain", self.actions["plain_traffic"].isChecked, self.actions["plain_traffic"].setChecked
        )
        self.serve(self.caster, self._take)
        targets.counted.connect(self._on_counts)
        self._on_counts()

    @property
    def is_current(self) -> bool:
        """Return whether the view shows what was asked last."""
        return self._asked is None

    @property
    def _traffic(self) -> Traffic | None:
        answer = self._targets.answer
        return None if answer is None else answer.traffic

    def _on_counts(self) -> None:
        traffic = self._traffic
        self._targets.panel.set_frames(0 if traffic is None else traffic.frames)
        for key in ("show_frame", "next_missed", "play_frames"):
            self.actions.allow(key, "" if traffic is not None else "The traffic is not loaded.")
        answer = self._targets.answer_on_scene
        if self._plain is None and answer is not None:
            self._plain = plain_frame(answer.traffic)
            self._show_plain()

    def _show_plain(self) -> None:
        """Show plain bodies, or none, unless a frame is chosen."""
        wanted = self._plain if self.actions["plain_traffic"].isChecked() else None
        if self._shown is None and self.viewport.state.traffic is not wanted:
            self._draw(wanted)

    def _draw(self, shown: ShownFrame | None) -> None:
        """Draw a frame on its streets, or none."""
        from riglens.core.scene.readers.bundled import (
            streets_around,
        )  # reads tables: not while the window opens

        traffic = self._traffic
        streets = None if shown is None or traffic is None else streets_around(traffic.data, shown.frame)
        self.viewport.show_state(replace(self.viewport.state, traffic=shown, streets=streets))

    # ------------------------------------------------------------------ choosing
    def _choose(self, frame: int | None) -> None:
        """Show a frame by its number in the data, or none."""
        traffic = self._traffic
        if frame is None or traffic is None:
            self._show(None)
        else:
            self._show(_Shown(int(np.flatnonzero(traffic.frame == frame)[0]), None))

    def forget_scene(self) -> None:
        """Show no frame of other traffic, and release it."""
        self._missed = self._plain = None
        self._choose(None)

    def play(self, wanted: bool) -> None:
        """Play back frames from the one shown, or stop."""
        self._is_playing = wanted and self._traffic is not None
        self._targets.panel.show_playing(self._is_playing)
        self.actions["play_frames"].setChecked(self._is_playing)
        if not self._is_playing:
            self._next.stop()
            return
        if self._shown is None:
            self._choose(0)
        self._next.start()

    def _show_next(self) -> None:
        """Show the frame after the one shown, after the last the first; none is left out while one is being made."""
        traffic, shown = self._traffic, self._shown
        if not self._is_playing or traffic is None or shown is None:
            return
        if self.is_current:
            self._choose((int(traffic.frame[shown.place]) + 1) % traffic.frames)
        self._next.start()

    def _follow(self, is_on: bool) -> None:
        """Follow edits while a frame is shown."""
        document = self.document
        for changed in (
            document.rig_changed, document.rig_settled, document.failed_changed, document.vehicle_changed,
            self.session.targets_changed,
            self.session.settings_changed,
        ):  # fmt: skip
            if is_on:
                changed.connect(self._ask)
            else:
                changed.disconnect(self._ask)

    def _show(self, shown: _Shown | None) -> None:
        if (shown is None) != (self._shown is None):
            self._follow(shown is not None)
        self._shown, self._last, self._asked = shown, None, None
        traffic = self._traffic
        frame = None if shown is None or traffic is None else int(traffic.frame[shown.place])
        self._targets.panel.show_frame(frame)
        self._targets.panel.unsay()
        self.actions["show_frame"].setChecked(shown is not None)
        if shown is None and self._is_playing:
            self.play(False)
        if shown is None:
            self._show_plain()
            self.drawn.emit()
        if frame is not None:
            self.frame_chosen.emit(frame)
        self._ask()

    def show_next_missed(self) -> None:
        """Show the next missed object, the nearest first, and the reason."""
        answer = self._targets.answer
        if answer is None:
            return
        self.play(False)
        objects, distance_m = missed_objects(answer), answer.traffic.distance_m
        if not objects:
            self._targets.panel.say(NONE_MISSED)
            return
        found = 0
        if self._missed is not None and self._missed[0] == answer.request:
            # the same rig, of more frames by now, perhaps: go on behind the one shown last
            shown = self._missed[1]
            behind = [(distance_m[box], box) > (distance_m[shown], shown) for box in objects]
            found = behind.index(True) if True in behind else 0
        self._missed = (answer.request, objects[found])
        self._fly_to(answer.traffic, objects[found])

    def _fly_to(self, traffic: Traffic, box: int) -> None:
        place = int(traffic.frame_of_box[box])
        self._show(_Shown(place, box - int(traffic.starts[place])))
        x_m, y_m, _ = traffic.centre_m[box].tolist()
        self.viewport.look_at(x_m, y_m)

    # ------------------------------------------------------------------ asking and showing
    def _ask(self) -> None:
        """Request the chosen frame with the current rig."""
        traffic, shown = self._traffic, self._shown
        if shown is None or traffic is None:
            return
        session = self.session
        settings = replace(session.targets, body=session.body)
        request = FrameRequest(
            session.working_rig, traffic, shown.place, settings, shown.explain, self.document.is_dragging
        )
        if request != self._last:
            self._last = self._asked = request
            self.caster.ask(request)

    def _take(self, request: FrameRequest, answer: FrameAnswer) -> None:
        """Show a result; also one for an earlier pose, until the next arrives."""
        (scene, missed), shown = answer, self._shown
        if shown is None or (request.place, request.explain) != shown or request.traffic is not self._traffic:
            return
        if request is self._asked:
            self._asked = None
        frame = shown_frame(scene, request.settings.min_points, request.explain)
        self._draw(frame)
        self.drawn.emit()
        if missed is not None and request.explain is not None:
            self._targets.panel.say(missed_text(scene, request.explain, missed), stays=True)


def missed_objects(answer: CountAnswer) -> list[int]:
    """Return the indices in the traffic of objects that nothing detects, the nearest first."""
    objects, traffic = answer.counted.objects, answer.traffic
    detected = objects.detected(answer.counted.settings.min_points)
    boxes = objects.box[~np.any(list(detected.values()), axis=0)]
    return [int(box) for box in boxes[np.argsort(traffic.distance_m[boxes], kind="stable")]]


def shown_frame(scene: FrameScene, enough: int, pointed_out: int | None) -> ShownFrame:
    """Return what the 3D view draws of a frame."""
    boxes = scene.boxes
    return ShownFrame(
        boxes.cls, boxes.centre_m, boxes.size_m, boxes.rotation, scene.points, scene.places_m, scene.box >= 0,
        enough, pointed_out, frame=scene.frame,
    )  # fmt: skip


def missed_text(scene: FrameScene, number: int, missed: Missed) -> str:
    """Describe the missed object, its place, and the reason."""
    who = f"Missed: {_name(scene, number)}"
    if missed.verdict == "no LiDARs":
        return f"{who}: no LiDAR is enabled"
    if missed.verdict == "out of range":
        return f"{who}: out of range of every LiDAR"
    points = f"{missed.points} of {_points(missed.alone)} reach it"
    if missed.verdict == "hidden":
        return f"{who}: {points}, behind {_obstacle(scene, missed.by)}"
    if missed.verdict == "between beams":
        return f"{who}: between beams, {_points(missed.alone)} even without occlusion"
    return f"{who}: {points}"


def _points(number: int) -> str:
    return f"{number:,} point{'s' * (number != 1)}"


def _obstacle(scene: FrameScene, by: int | None) -> str:
    if by is None:
        return "an object in front of it"
    if by == BODY:
        return "the own car's body"
    return "the ground" if by == GROUND else _name(scene, by)


def _name(scene: FrameScene, number: int) -> str:
    return box_name(int(scene.boxes.cls[number]), scene.boxes.centre_m[number])


def box_name(cls: int, centre_m: NDArray[np.float64]) -> str:
    """Return a box in words: class, distance and direction."""
    x_m, y_m, _ = centre_m.tolist()
    name = CLASSES[cls] if cls < len(CLASSES) else "an occluder"
    return f"{name}, {math.hypot(x_m, y_m):.0f} m, {SECTORS[int(sector_of(x_m, y_m))]}"
