"""Schedule drawing: soon after a change, and once more in full quality when nothing has changed for a while."""

from __future__ import annotations

from collections.abc import Callable, Generator

from PySide6.QtCore import QObject

from riglens.widgets.timers import Timers, single_shot

REST_MS = 250
"""A view in which nothing has changed for so long is at rest."""
Parts = Generator[None, None, None]
"""Draws a part of a picture each time it is resumed."""


class Redraw(QObject):
    """Scheduler of frames: `draw` after each change, `draw_rested` some time after the last of them.

    A rested frame takes longest, so it waits while the mouse is moving, and the event loop gets a turn wherever it
    yields. With `in_parts`, what changes while nothing moves is drawn like that at once. Motion abandons
    what has not been drawn yet; any other change waits for it.
    """

    def __init__(
        self,
        parent: QObject,
        draw: Callable[[], None],
        draw_rested: Callable[[], Parts],
        in_parts: Callable[[], bool] = lambda: False,
        timers: Timers = single_shot,
    ) -> None:
        super().__init__(parent)
        self._draw, self._draw_rested, self._in_parts = draw, draw_rested, in_parts
        self._parts: Parts | None = None
        self._is_stopped = False
        self._soon = timers(self, 0, self.now)
        self._rest = timers(self, REST_MS, self._begin)
        self._next = timers(self, 0, self._go_on)

    @property
    def is_at_rest(self) -> bool:
        """Return whether nothing waits to be drawn."""
        return not any(timer.isActive() for timer in (self._soon, self._rest, self._next))

    @property
    def is_busy(self) -> bool:
        """Return whether a frame has just been drawn, or is being drawn: the next change is one of many."""
        return self._rest.isActive() or self._next.isActive()

    def request(self) -> None:
        """Draw once, soon; any number of changes until then make one frame."""
        if not self._is_stopped and not self._soon.isActive():
            self._soon.start()

    @property
    def is_due(self) -> bool:
        """Return whether a frame is scheduled."""
        return self._soon.isActive()

    def next_turn(self) -> None:
        """Draw in the next turn of the event loop: this one has been long enough."""
        if self._soon.isActive():
            self._soon.start()

    def now(self) -> None:
        """Draw the scheduled frame."""
        if not self._in_parts():
            self.taken_over()
            self._draw()
        elif self._next.isActive():
            self._soon.start()  # its timeout comes after that of the next part
        else:
            self._begin()

    def taken_over(self) -> None:
        """Note that the scheduled frame is being drawn elsewhere: only the rested frame is due."""
        self._give_up()
        self._soon.stop()
        if not self._is_stopped:
            self._rest.start()

    def postpone_rest(self) -> None:
        """Postpone the rested frame, if one is due, while the user is active."""
        if self._rest.isActive():
            self._rest.start()

    def stop(self) -> None:
        """Request no more frames."""
        self._is_stopped = True
        self._give_up()
        self._soon.stop()
        self._rest.stop()

    def _begin(self) -> None:
        self._give_up()
        self._rest.stop()
        self._parts = self._draw_rested()
        self._go_on()

    def _go_on(self) -> None:
        parts, self._parts = self._parts, None
        for _ in parts or ():
            if not self._is_stopped:
                self._parts = parts
                self._next.start()
            return

    def _give_up(self) -> None:
        """Abandon the current drawing."""
        self._next.stop()
        parts, self._parts = self._parts, None
        if parts is not None:
            parts.close()
