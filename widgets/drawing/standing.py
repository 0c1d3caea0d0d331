"""Cache the static part of the scene during a drag: drawn once, kept with its depths, and laid under what moves.

Nobody has to say what moves. Whatever has changed since the frame before is drawn over the kept picture from then on,
until the camera moves or `forget` is called. Solid things are hidden by each other as usual, by their depths; rays
of what moves are drawn over those of what does not, as they are anyway. Only this differs from a picture drawn in one
go: what is clear and stands still (a ray, a field of view) does not tint a body that moves behind it.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from functools import partial
from time import perf_counter

from vtkmodules.vtkRenderingCore import vtkProp, vtkRenderer

from riglens.widgets.drawing.stage import Stage, props_of

Clock = Callable[[], float]
_PAUSE = 2.0
"""For how long another haze may wait, as a multiple of the time that the last one took."""


class Standing:
    """Frames of a stage while something moves; between two of them only the scene may touch the stage.

    The static part takes several times as long as the moving one. With another haze it is therefore drawn in `parts`,
    beside the picture that frames in between are laid over; haze that follows closely waits (`is_due`), so that it gets
    at most a third of the time. Large clear surfaces below everything else, `low`, are drawn with the haze; those in
    `over` lie over what may move, so they are drawn with that in every frame.
    """

    def __init__(
        self,
        stage: Stage,
        clock: Clock = perf_counter,
        low: tuple[vtkProp, ...] = (),
        over: tuple[vtkProp, ...] = (),
    ) -> None:
        self._stage, self._clock, self._low, self._over = stage, clock, frozenset(low), frozenset(over)
        self._haze_due_s = 0.0
        self._place: object = None
        self._changed: dict[vtkProp, int] = {}
        self._moving: set[vtkProp] = set()
        self._kept: tuple[tuple[object, ...], frozenset[vtkProp]] | None = None

    def forget(self) -> None:
        """Take everything for standing still again; what was kept is not used any more."""
        self._place, self._kept = None, None
        self._changed, self._moving = {}, set()

    def is_kept(self, place: object) -> bool:
        """Return whether the haze of the last frame will do for this one, so that another one need not be made
        ready."""
        return self._kept is not None and place == self._place

    def is_due(self, place: object, haze: tuple[object, ...]) -> bool:
        """Return whether the kept picture must be redrawn, in `parts`, because this haze is new."""
        kept = self._kept if self.is_kept(place) else None
        return kept is not None and not _are_same(kept[0], haze) and self._clock() >= self._haze_due_s

    def parts(self, haze: tuple[object, ...]) -> Generator[None, None, bool]:
        """Draw the static part with the current haze; return whether frames are now laid over it.

        Frames may be drawn wherever this yields. If the static part has changed, they need another
        picture of it, and the rest is abandoned.
        """
        stage, kept, took_s = self._stage, self._kept, 0.0
        if kept is None:
            return False
        main, rays = partial(stage.draw, stage.main), partial(stage.draw, stage.rays)
        parts: tuple[Callable[[], None], ...] = (self._draw_below, main, rays)
        for number, part in enumerate(parts):
            if number > 0:
                yield
            if self._kept is not kept:
                return False
            began_s = self._clock()
            if number > 0:
                stage.lay_begun()
            self._draw_but(self._visible().keys() - kept[1], part)
            stage.keep_begun()
            took_s += self._clock() - began_s
        stage.swap_begun()
        self._kept = (haze, kept[1])
        self._haze_due_s = self._clock() + _PAUSE * took_s
        return True

    def draw(self, place: object, haze: tuple[object, ...]) -> None:
        """Draw the current frame, which depends on `place` (camera, size), haze and what is low on the objects in
        `haze`.

        While `place` changes from frame to frame, all is drawn at once, as if nothing were kept.
        """
        stage = self._stage
        if place != self._place:
            self.forget()
            self._place = place
            stage.draw_all()
        else:
            visible = self._visible()
            self._moving |= {prop for prop, time in visible.items() if self._changed.get(prop) != time}
            self._moving |= self._over & visible.keys()
            self._moving -= self._low
            still = frozenset(visible.keys() - self._moving)
            if self._kept is None or self._kept[1] != still or not _are_same(self._kept[0], haze):
                began_s = self._clock()
                self._draw_but(visible.keys() - still, self._draw_still)
                self._kept = (haze, still)
                self._haze_due_s = self._clock() + _PAUSE * (self._clock() - began_s)
            stage.lay_kept()
            self._draw_but(still, self._draw_moving)
        self._changed = self._visible()

    def _visible(self) -> dict[vtkProp, int]:
        """Return the visible props that may be cached, and when each changed last."""
        both = (*props_of(self._stage.main), *props_of(self._stage.rays))
        return {prop: prop.GetRedrawMTime() for prop in both if prop.GetVisibility()}

    def _below(self) -> list[vtkRenderer]:
        return [renderer for renderer in (self._stage.backdrop, self._stage.haze) if renderer.GetDraw()]

    def _draw_below(self) -> None:
        self._stage.draw(*self._below())

    def _draw_still(self) -> None:
        self._stage.draw(*self._below(), self._stage.main, self._stage.rays)
        self._stage.keep()

    def _draw_moving(self) -> None:
        stage = self._stage
        stage.main.PreserveDepthBufferOn()
        stage.draw(stage.main, stage.rays, stage.overlay)
        stage.main.PreserveDepthBufferOff()

    @staticmethod
    def _draw_but(hidden: Iterable[vtkProp], draw: Callable[[], None]) -> None:
        """Draw without some of the visible props."""
        for prop in hidden:
            prop.SetVisibility(False)
        draw()
        for prop in hidden:
            prop.SetVisibility(True)


def _are_same(some: tuple[object, ...], others: tuple[object, ...]) -> bool:
    """Return whether these are the very same objects; what they hold is not compared."""
    return len(some) == len(others) and all(one is other for one, other in zip(some, others, strict=True))
