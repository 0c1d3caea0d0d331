"""When a view is drawn: soon after a change, and once more in full quality when nothing has changed for a while."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer

_REST_MS = 250


class Redraw(QObject):
    """Asks for frames: `draw` as often as something changes, `draw_rested` some time after the last of them.

    A rested frame takes longest, so it waits while the mouse is on its way to something.
    """

    def __init__(
        self,
        parent: QObject,
        draw: Callable[[], None],
        draw_rested: Callable[[], None],
        rest_ms: int = _REST_MS,
    ) -> None:
        super().__init__(parent)
        self._draw, self._is_stopped = draw, False
        self._soon, self._rest = QTimer(self), QTimer(self)
        self._rest.setInterval(rest_ms)
        for timer, slot in ((self._soon, self.now), (self._rest, draw_rested)):
            timer.setSingleShot(True)
            timer.timeout.connect(slot)

    @property
    def is_at_rest(self) -> bool:
        """Whether nothing waits to be drawn."""
        return not (self._soon.isActive() or self._rest.isActive())

    @property
    def is_busy(self) -> bool:
        """Whether a frame has just been drawn: the next change comes in the midst of others."""
        return self._rest.isActive()

    def request(self) -> None:
        """Draw once, soon; any number of changes until then make one frame."""
        if not self._is_stopped and not self._soon.isActive():
            self._soon.start()

    def now(self) -> None:
        """Draw what has been asked for."""
        self.taken_over()
        self._draw()

    def taken_over(self) -> None:
        """What has been asked for is being drawn: only the rested frame is due."""
        self._soon.stop()
        self._rest.start()

    def postpone_rest(self) -> None:
        """Somebody is doing something: wait longer with the rested frame, if one is due."""
        if self._rest.isActive():
            self._rest.start()

    def stop(self) -> None:
        """Ask for no more frames."""
        self._is_stopped = True
        self._soon.stop()
        self._rest.stop()
