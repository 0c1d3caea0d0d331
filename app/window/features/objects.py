"""Checks > Test objects: the objects near the car that the rig sees, while it is edited; a click goes to one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from riglens.app.background.rig_questions import RigRequest, object_verdicts
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.features.checks import LiveCheck, check_spec
from riglens.app.window.workbench import Workbench
from riglens.core.metric.scores import Body
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.panels.checks.objects import ObjectsPanel
from riglens.widgets.viewport.scene_state import Post

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.review.verdicts import ProfileVerdict

FAR_M, LEAST_DEG, MOST_DEG = 9.0, 20.0, 60.0
"""Largest distance from which an object is viewed, and the range of elevations."""


class Objects(LiveCheck[ObjectsPanel, RigRequest[Body], "tuple[ProfileVerdict, ...]"]):
    """Visibility of objects; failed sensors are ignored."""

    specs = (
        check_spec(
            "test_objects", "Test objects",
            "Check which objects of UN R158, R159, R151, FMVSS 111 and the turn assist the rig sees: geometry only.",
        ),
    )  # fmt: skip

    def __init__(
        self,
        bench: Workbench,
        worker: BackgroundWorker[RigRequest[Body], tuple[ProfileVerdict, ...]] | None = None,
    ) -> None:
        self._profiles: Sequence[ProfileVerdict] = ()
        self._chosen: tuple[int, int] | None = None
        page = ObjectsPanel()
        super().__init__(
            bench, "test_objects", page, worker or BackgroundWorker("test objects", object_verdicts, bench)
        )
        page.chosen.connect(self._go_to)
        self._worker.progressed.connect(
            lambda _, share: page.bar.show_share(share), Qt.ConnectionType.QueuedConnection
        )

    def _turn(self, is_seen: bool) -> None:
        super()._turn(is_seen)
        if not is_seen:
            self.page.bar.show_share(None)
            self._chosen = None
            self._point_out()

    def _request(self) -> RigRequest[Body]:
        return RigRequest(self.session.working_rig, self.session.solid_body)

    def _show(self, answer: tuple[ProfileVerdict, ...]) -> None:
        self._profiles = answer
        self.page.show_verdicts(answer)
        self._point_out()

    def _go_to(self, profile: int, place: int) -> None:
        """Point the view at an object from outside, with the car behind it, and highlight the object."""
        self._chosen = (profile, place)
        state, post = self.viewport.state, self._post()
        if post is not None:
            self.viewport.show_state(replace(state, camera=beside(state.camera, post), post=post))

    def _point_out(self) -> None:
        """Mark the chosen object at its current place, and show whether it is seen."""
        state, post = self.viewport.state, self._post()
        if post != state.post:
            self.viewport.show_state(replace(state, post=post))

    def _post(self) -> Post | None:
        if self._chosen is None:
            return None
        profile, place = self._chosen
        if profile >= len(self._profiles) or place >= len(self._profiles[profile].objects):
            return None
        one = self._profiles[profile].objects[place]
        return Post(one.target.x_m, one.target.y_m, one.target.radius_m, one.target.height_m, one.is_seen)


def beside(camera: OrbitCamera, post: Post) -> OrbitCamera:
    """Return a camera that views an object in front of the car: from its own side, and close."""
    return replace(
        camera,
        focal_m=(post.x_m, post.y_m, post.height_m / 2.0),
        azimuth_deg=math.degrees(math.atan2(post.y_m, post.x_m)),
        elevation_deg=min(max(camera.elevation_deg, LEAST_DEG), MOST_DEG),
        distance_m=min(camera.distance_m, FAR_M),
        parallel=camera.orthographic,
    )
