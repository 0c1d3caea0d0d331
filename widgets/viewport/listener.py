"""What a view's controller tells, and the words it uses: who listens gets picks, drags and nudges of sensors."""

from __future__ import annotations

from typing import Literal, Protocol

from riglens.core.geometry import Pose

Pixel = tuple[float, float]
"""Right and down from the upper left corner."""
Button = Literal["left", "middle", "right", "none"]


class Listener(Protocol):
    """Who hears what mouse and keys did."""

    def on_picked(self, name: str | None) -> None:
        """A click chose a sensor, or nothing."""

    def on_drag_started(self, name: str) -> None:
        """A handle of the sensor was grasped, or the sensor is being placed."""

    def on_drag_moved(self, name: str, pose: Pose) -> None:
        """The sensor was dragged here; the scene shows it already."""

    def on_drag_finished(self, name: str) -> None:
        """The handle was let go."""

    def on_drag_cancelled(self, name: str) -> None:
        """The drag was given up; the scene shows the start pose again."""

    def on_nudged(self, name: str, pose: Pose) -> None:
        """A key moved the sensor here."""

    def on_placing(self, active: bool) -> None:
        """A sensor follows the mouse over the car, or no longer."""

    def on_changed(self) -> None:
        """The scene needs to be drawn again."""
