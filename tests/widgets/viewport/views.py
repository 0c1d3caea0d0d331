"""Views on the screen for tests: both kinds, what they emit and draw, and where things are in them."""

import itertools
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.widgets.gizmo.drag import Handle
from riglens.widgets.gizmo.handles import handle_polyline
from riglens.widgets.viewport.offscreen import OffscreenViewport
from riglens.widgets.viewport.viewport import Viewport
from tests.hand_clock import HandTimers
from tests.waiting import TIMEOUT_MS, wait_for
from tests.widgets.mouse import hover

LIDAR = Lidar(
    name="roof",
    position=(0.2, 0.5, 2.2),
    rpy_deg=(0.0, 0.0, 20.0),
    elevations_deg=LinearAngles(from_=-25.0, to=25.0, count=16),
)
CAMERA = Camera(name="front", position=(1.5, -0.9, 1.3), hfov_deg=70.0, cast=(352, 128))
RIG = Rig(sensors=(LIDAR, CAMERA))


class Window(Viewport):
    """The view in a window, with timers driven by hand."""

    def __init__(self) -> None:
        timers = HandTimers()
        super().__init__(timers=timers)
        self.timers, self.is_current = timers, True
        self.drawn.connect(self._on_drawn)
        self._plotter.frameSwapped.connect(self._on_swapped)

    def _on_drawn(self) -> None:
        self.is_current = False

    def _on_swapped(self) -> None:
        self.is_current = True


class Offscreen(OffscreenViewport):
    """The view as a picture, with timers driven by hand."""

    is_current = True

    def __init__(self) -> None:
        timers = HandTimers()
        super().__init__(timers=timers)
        self.timers = timers


AnyView = Window | Offscreen
BOTH = [pytest.param(Window, id="window"), pytest.param(Offscreen, id="offscreen", marks=pytest.mark.slow)]
KINDS = pytest.mark.parametrize("kind", BOTH)


def change(view: AnyView, **fields: Any) -> None:
    """Show another state: these fields are others."""
    view.show_state(replace(view.state, **fields))


def shown(kind: type[AnyView], qtbot: QtBot, size: tuple[int, int] = (900, 600), **fields: Any) -> AnyView:
    """A view on the screen that has drawn everything."""
    made = kind()
    qtbot.addWidget(made)  # left to garbage collection its parts go in any order, which Qt does not survive
    made.resize(*size)
    change(made, **fields)
    with qtbot.waitExposed(made, timeout=TIMEOUT_MS):
        made.show()
    settle(made)
    return made


@dataclass
class Heard:
    """What a viewport emitted, in order."""

    signals: list[tuple[Any, ...]] = field(default_factory=list)
    frames: int = 0

    def pose(self, name: str = "roof") -> Any:
        """Where a sensor was moved to last."""
        return next(signal[1] for signal in reversed(self.signals) if signal[0] in ("drag_moved", "nudged"))[
            name
        ]

    def story(self) -> list[object]:
        """Names of the signals, repetitions left out: a real pointer may report a place twice."""
        return [name for name, _ in itertools.groupby(signal[0] for signal in self.signals)]


def listen(view: AnyView) -> Heard:
    heard = Heard()
    names = (
        "sensor_picked",
        "sensor_toggled",
        "sensors_boxed",
        "menu_wanted",
        "drag_started",
        "drag_moved",
        "drag_finished",
        "drag_cancelled",
    )
    for name in (*names, "nudged", "placing_changed", "model_dropped"):
        getattr(view, name).connect(lambda *values, name=name: heard.signals.append((name, *values)))

    def count() -> None:
        heard.frames += 1

    view.drawn.connect(count)
    return heard


def settle(view: AnyView) -> None:
    """Have the last frame drawn, the one with smooth edges, and wait until it is on the screen."""
    QApplication.processEvents()
    view.timers.run_out()
    assert view.is_at_rest
    wait_for(lambda: view.is_current)
    QApplication.processEvents()


def to_point(view: AnyView, pixel: np.ndarray) -> QPoint:
    return QPoint(round(float(pixel[0])), round(float(pixel[1])))


def pixel_at(view: AnyView, position_m: np.ndarray | tuple[float, ...]) -> np.ndarray:
    scene = view._scene
    return scene.state.camera.project(np.array(position_m), scene.size)[0, :2]


def handle_pixel(view: AnyView, handle: Handle) -> np.ndarray:
    """A pixel at which exactly this handle is grasped."""
    scene = view._scene
    gizmo = scene.under_mouse.gizmo()
    assert gizmo is not None
    line = handle_polyline(handle, gizmo, scene.state.camera)
    pixels = np.round(scene.state.camera.project(line[~np.isnan(line).any(axis=1)], scene.size)[:, :2])
    pixels = np.concatenate([pixels, (pixels[:-1] + pixels[1:]) // 2])
    return next(pixel for pixel in pixels if scene.under_mouse.handle(tuple(pixel)) == handle)


def drag(view: AnyView, start: np.ndarray, end: np.ndarray, release: bool = True) -> None:
    canvas = view._canvas
    hover(canvas, to_point(view, start))
    QTest.mousePress(canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    for share in (0.3, 0.7, 1.0):
        hover(canvas, to_point(view, start + share * (end - start)), Qt.MouseButton.LeftButton)
        view.timers.advance(5)
    if release:
        QTest.mouseRelease(canvas, Qt.MouseButton.LeftButton, pos=to_point(view, end))


@dataclass
class Frames:
    """How the frames of a viewport were drawn: coarse or in full, with rough or smooth edges."""

    view: AnyView
    looks: list[str] = field(default_factory=list)

    def note(self) -> None:
        scene = self.view._scene
        coarse = "coarse" if scene._stage.haze_size != scene.size else "full"
        self.looks.append(coarse + (" smooth" if scene._smooth else ""))


def frames_of(view: AnyView) -> Frames:
    frames = Frames(view)
    view.drawn.connect(frames.note)
    return frames


def one_change(view: AnyView) -> list[str]:
    """How a change is drawn that stands alone: a graphics card draws twice in no time; without one, in parts, once."""
    return ["full", "full smooth"] if isinstance(view, Viewport) else ["full smooth"]


def picture(view: AnyView, wait: bool = True) -> np.ndarray:
    if wait:
        settle(view)
    image = view.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    if isinstance(view, Viewport):
        screen = QApplication.primaryScreen()
        shot = screen.grabWindow(view._canvas.winId()).toImage()
        image = shot.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), dtype=np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)
