"""Stage of a scene: renderers on top of each other in one window, seen through one camera.

`backdrop` has what lies behind everything else: background and ground. `haze` is the heatmap and footprints while
something moves: large areas, which take most of a frame's time without a graphics card, so they are drawn at a fraction
of their size and stretched over the backdrop. `main` has car and sensors; `cells` the heatmap at rest, among them by
their depths; `rays` what the heatmap does not hide but the car does; `overlay` what is never hidden.
"""

from __future__ import annotations

import weakref
from typing import cast

import pyvista as pv
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR, vtkCommand
from vtkmodules.vtkRenderingCore import vtkProp, vtkRenderer, vtkRenderWindow
from vtkmodules.vtkRenderingOpenGL2 import (
    vtkOpenGLFramebufferObject,
    vtkOpenGLRenderWindow,
    vtkTextureObject,
)

from riglens.widgets.drawing.camera import OrbitCamera, Size
from riglens.widgets.drawing.lights import set_lights

COARSE = 3
"""Pixels of the window per pixel of the haze, along each side."""
_GL_READ_FRAMEBUFFER, _GL_DRAW_FRAMEBUFFER = 0x8CA8, 0x8CA9
_GL_COLOR_BUFFER_BIT, _GL_DEPTH_BUFFER_BIT, _GL_NEAREST = 0x4000, 0x0100, 0x2600
_DEPTH_BITS = 32
_GL_SCISSOR_TEST, _GL_DEPTH_TEST, _GL_BLEND, _GL_ONE, _GL_ONE_MINUS_SRC_ALPHA = (
    0x0C11,
    0x0B71,
    0x0BE2,
    1,
    0x0303,
)
_USUAL_BLENDING = (0x0302, _GL_ONE_MINUS_SRC_ALPHA, _GL_ONE, _GL_ONE_MINUS_SRC_ALPHA)


class Stage:
    """The renderers of a plotter's window."""

    def __init__(self, plotter: pv.BasePlotter) -> None:
        self._plotter = plotter
        self._below, self._haze_drawn = vtkOpenGLFramebufferObject(), vtkOpenGLFramebufferObject()
        self._kept, self._begun = vtkOpenGLFramebufferObject(), vtkOpenGLFramebufferObject()
        self._coarse_size: Size | None = None
        self._wanted_backdrop: object = None
        self._kept_backdrop: object = None
        self._last_size: Size = (1, 1)
        self.backdrop = plotter.renderer
        self.backdrop.SetUseOIT(False)  # cells are sorted already; weighted blending would cost another pass
        self.backdrop.camera_set = True
        self.haze, self.main, self.cells, self.rays, self.overlay = (self._renderer_above() for _ in range(5))
        self.cells.PreserveDepthBufferOn()
        self.rays.PreserveDepthBufferOn()
        self.overlay.GetCullers().RemoveAllItems()
        set_lights(self.main)
        self.haze.SetPreserveColorBuffer(False)
        self.haze.SetBackgroundAlpha(0.0)
        for event, step in ((vtkCommand.StartEvent, self._make_room), (vtkCommand.EndEvent, self._stretch)):
            weak = weakref.WeakMethod(step)
            self.haze.AddObserver(event, lambda *_, weak=weak: (call := weak()) and call())

    def _renderer_above(self) -> vtkRenderer:
        """Add a renderer that is drawn over the earlier ones."""
        window = render_window(self._plotter)
        renderer = vtkRenderer()
        window.SetNumberOfLayers(window.GetNumberOfLayers() + 1)
        renderer.SetLayer(window.GetNumberOfLayers() - 1)
        renderer.InteractiveOff()
        renderer.SetUseOIT(False)
        renderer.SetActiveCamera(self.backdrop.camera)
        window.AddRenderer(renderer)
        return renderer

    @property
    def size(self) -> Size:
        """Width and height of the picture in pixels; once the plotter is closed, the last ones."""
        window = self._plotter.render_window
        if window is not None:
            width, height = window.GetSize()
            self._last_size = int(width), int(height)
        return self._last_size

    @property
    def haze_size(self) -> Size:
        """Width and height in pixels at which the haze is drawn."""
        return self._coarse_size or self.size

    def set_smooth(self, smooth: bool) -> None:
        """Smooth the edges of the next frame by a filter over the finished picture (FXAA), but not of its words.

        Several samples per pixel would be smoother yet, and take three times as long as all the rest. Call it before
        each frame: a renderer runs the filter only if it draws something, and the last one that does must.
        """
        is_last = any(prop.GetVisibility() for prop in props_of(self.overlay))
        self.overlay.SetUseFXAA(smooth and is_last)
        self.main.SetUseFXAA(smooth and not is_last)

    def set_coarse(self, coarse: bool, backdrop: object) -> None:
        """Draw the haze in the next frames, at a fraction of their size, or leave it out.

        `backdrop` is whatever the look of the backdrop depends on: as long as it is equal, haze is laid over the same
        picture of it, which is not drawn again.
        """
        width, height = self.size
        self._coarse_size = (-(-width // COARSE), -(-height // COARSE)) if coarse else None
        part = self.haze_size
        self.haze.SetViewport(0.0, 0.0, part[0] / width, part[1] / height)
        self.haze.SetDraw(coarse)
        self._wanted_backdrop = (backdrop, self.size)
        self.backdrop.SetDraw(not coarse or self._kept_backdrop != self._wanted_backdrop)

    def set_camera(self, orbit: OrbitCamera, reach_m: float) -> None:
        """Look through a camera at everything nearer than its focal point plus `reach_m`."""
        camera = self.backdrop.camera
        camera.SetPosition(*orbit.position_m())
        camera.SetFocalPoint(*orbit.focal_m)
        camera.SetViewUp(*orbit.axes()[1])
        camera.SetViewAngle(orbit.view_angle_deg)
        camera.SetParallelProjection(orbit.parallel)
        camera.SetParallelScale(orbit.half_height_m())
        near_m = -reach_m if orbit.parallel else max(0.05, 0.02 * orbit.distance_m)
        camera.SetClippingRange(near_m, orbit.distance_m + reach_m)
        for renderer in (self.haze, self.main, self.cells, self.rays, self.overlay):
            renderer.SetActiveCamera(camera)

    def draw(self, *chosen: vtkRenderer) -> None:
        """Draw only these renderers, over the content of the window; there is no haze in such pictures."""
        renderers = (self.backdrop, self.haze, self.main, self.cells, self.rays, self.overlay)
        for renderer in renderers:
            renderer.SetDraw(renderer in chosen)
        window = render_window(self._plotter)
        window.Render()
        window.WaitForCompletion()
        for renderer in renderers:
            renderer.SetDraw(renderer is not self.haze)

    def draw_all(self) -> None:
        """Draw the visible parts of all renderers at once."""
        window = render_window(self._plotter)
        window.Render()
        window.WaitForCompletion()

    def keep(self) -> None:
        """Keep the content of the window, colours and depths."""
        self._exchange(self._kept, to_kept=True)

    def lay_kept(self) -> None:
        """Put what was kept into the window, where the next renderers draw over it."""
        self._exchange(self._kept, to_kept=False)

    def keep_begun(self) -> None:
        """Keep the content of the window next to the kept picture, to continue it later."""
        self._exchange(self._begun, to_kept=True)

    def lay_begun(self) -> None:
        """Put what was begun into the window, to draw the next part of it."""
        self._exchange(self._begun, to_kept=False)

    def swap_begun(self) -> None:
        """Replace the kept picture by the continued one, which is complete."""
        self._kept, self._begun = self._begun, self._kept

    def _exchange(self, kept: vtkOpenGLFramebufferObject, to_kept: bool) -> None:
        """Copy the whole picture from the window, or back into it."""
        window, size = opengl_window(self.main), self.size
        window.MakeCurrent()
        window.GetState().PushFramebufferBindings()
        self._fit(kept, size, has_depth=True)
        frame = window.GetRenderFramebuffer()
        source, target = (frame, kept) if to_kept else (kept, frame)
        self._copy(source, target, (0, 0, *size), _GL_COLOR_BUFFER_BIT | _GL_DEPTH_BUFFER_BIT)
        window.GetState().PopFramebufferBindings()

    def _fit(self, kept: vtkOpenGLFramebufferObject, size: Size, has_depth: bool = False) -> None:
        """Make room for a picture, unless there is."""
        kept.SetContext(opengl_window(self.main))
        kept.GetLastSize(known := [0, 0])
        if tuple(known) != size:
            kept.PopulateFramebuffer(*size, True, 1, VTK_UNSIGNED_CHAR, has_depth, _DEPTH_BITS, 0)

    def _make_room(self) -> None:
        """Keep the backdrop, if it has been drawn, before the haze is drawn in the lower left."""
        if self._coarse_size is None:
            return
        window = opengl_window(self.haze)
        frame, whole = window.GetRenderFramebuffer(), (0, 0, *self.size)
        window.GetState().PushFramebufferBindings()
        for kept, size in ((self._below, self.size), (self._haze_drawn, self._coarse_size)):
            self._fit(kept, size)
        if self.backdrop.GetDraw():
            self._copy(frame, self._below, whole)
            self._kept_backdrop = self._wanted_backdrop
        window.GetState().PopFramebufferBindings()

    def _stretch(self) -> None:
        """Take the haze out of its corner, restore the backdrop, and spread the haze over it."""
        if self._coarse_size is None:
            return
        window = opengl_window(self.haze)
        state, frame, corner = window.GetState(), window.GetRenderFramebuffer(), (0, 0, *self._coarse_size)
        state.PushFramebufferBindings()
        self._copy(frame, self._haze_drawn, corner)
        self._copy(self._below, frame, (0, 0, *self.size))
        haze = self._haze_drawn.GetColorAttachmentAsTextureObject(0)
        haze.SetMinificationFilter(vtkTextureObject.Linear)
        haze.SetMagnificationFilter(vtkTextureObject.Linear)
        state.vtkglDisable(_GL_DEPTH_TEST)
        state.vtkglEnable(_GL_BLEND)
        state.vtkglBlendFunc(
            _GL_ONE, _GL_ONE_MINUS_SRC_ALPHA
        )  # its colours have been multiplied by their opacity
        source, target = [n - 1 for n in self._coarse_size], [n - 1 for n in self.size]
        haze.CopyToFrameBuffer(0, 0, *source, 0, 0, *target, *self.size, None, None)  # type: ignore[call-overload]
        state.vtkglBlendFuncSeparate(*_USUAL_BLENDING)
        state.vtkglEnable(_GL_DEPTH_TEST)
        state.PopFramebufferBindings()

    def _copy(
        self,
        source: vtkOpenGLFramebufferObject,
        target: vtkOpenGLFramebufferObject,
        pixels: tuple[int, int, int, int],
        what: int = _GL_COLOR_BUFFER_BIT,
    ) -> None:
        """Copy a rectangle of pixels: their colours, their depths, or both."""
        state = opengl_window(self.haze).GetState()
        state.vtkglDisable(_GL_SCISSOR_TEST)
        source.Bind(_GL_READ_FRAMEBUFFER)
        source.ActivateReadBuffer(0)
        target.Bind(_GL_DRAW_FRAMEBUFFER)
        target.ActivateDrawBuffer(0)
        state.vtkglBlitFramebuffer(*pixels, *pixels, what, _GL_NEAREST)


def render_window(plotter: pv.BasePlotter) -> vtkRenderWindow:
    """Return the VTK window of an open plotter."""
    window: vtkRenderWindow | None = plotter.render_window
    if window is None:
        raise RuntimeError("the plotter is closed")
    return window


def opengl_window(renderer: vtkRenderer) -> vtkOpenGLRenderWindow:
    """Return the window of a renderer that is being drawn."""
    window = renderer.GetRenderWindow()
    assert isinstance(window, vtkOpenGLRenderWindow)
    return window


def props_of(renderer: vtkRenderer) -> list[vtkProp]:
    """Return everything that a renderer may show, visible or not."""
    props = renderer.GetViewProps()
    return [cast(vtkProp, props.GetItemAsObject(row)) for row in range(props.GetNumberOfItems())]
