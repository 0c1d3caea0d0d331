"""What a scene is drawn on: four renderers on top of each other in one window, seen through one camera.

`backdrop` has what lies behind everything else: background and ground, and while something moves the heatmap. These
are large areas, which take most of a frame's time without a graphics card, so in motion they are drawn at a fraction
of their size and stretched. `main` has car, sensors and rays; `cells` the heatmap at rest, among them by their depths;
`overlay` what is never hidden.
"""

from __future__ import annotations

import weakref
from typing import cast

import pyvista as pv
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR, vtkCommand
from vtkmodules.vtkRenderingCore import vtkProp, vtkRenderer, vtkRenderWindow
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLFramebufferObject, vtkOpenGLRenderWindow

from riglens.widgets.drawing.camera import OrbitCamera, Size
from riglens.widgets.drawing.lights import set_lights

COARSE = 3
"""How many pixels of the window a pixel of the coarse backdrop stands for, along each side."""
_GL_READ_FRAMEBUFFER, _GL_DRAW_FRAMEBUFFER = 0x8CA8, 0x8CA9
_GL_COLOR_BUFFER_BIT, _GL_NEAREST, _GL_LINEAR, _GL_SCISSOR_TEST = 0x4000, 0x2600, 0x2601, 0x0C11


class Stage:
    """The renderers of a plotter's window."""

    def __init__(self, plotter: pv.BasePlotter) -> None:
        self._plotter = plotter
        self._copy = vtkOpenGLFramebufferObject()
        self._coarse_size: Size | None = None
        self._last_size: Size = (1, 1)
        self.backdrop = plotter.renderer
        self.backdrop.SetUseOIT(False)  # cells are sorted already; weighted blending would cost another pass
        self.backdrop.camera_set = True
        self.main, self.cells, self.overlay = (self._renderer_above() for _ in range(3))
        self.cells.PreserveDepthBufferOn()
        self.overlay.GetCullers().RemoveAllItems()
        set_lights(self.main)
        stretch = weakref.WeakMethod(self._stretch)
        self.main.AddObserver(vtkCommand.StartEvent, lambda *_: (call := stretch()) and call())

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
    def backdrop_size(self) -> Size:
        """Width and height in pixels at which the backdrop is drawn."""
        return self._coarse_size or self.size

    def set_smooth(self, smooth: bool) -> None:
        """Smooth the edges of the next frame by a filter over the finished picture (FXAA), but not of its words.

        Several samples per pixel would be smoother yet, and take three times as long as all the rest. Call it before
        each frame: a renderer runs the filter only if it draws something, and the last one that does must.
        """
        is_last = any(prop.GetVisibility() for prop in props_of(self.overlay))
        self.overlay.SetUseFXAA(smooth and is_last)
        self.main.SetUseFXAA(smooth and not is_last)

    def set_coarse(self, coarse: bool) -> None:
        """Draw the backdrop of the next frames at a fraction of its size, or in full."""
        width, height = self.size
        self._coarse_size = (-(-width // COARSE), -(-height // COARSE)) if coarse else None
        part = self.backdrop_size
        self.backdrop.SetViewport(0.0, 0.0, part[0] / width, part[1] / height)

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
        for renderer in (self.main, self.cells, self.overlay):
            renderer.SetActiveCamera(camera)

    def draw(self, *chosen: vtkRenderer) -> None:
        """Draw only these renderers, over what is already in the window."""
        renderers = (self.backdrop, self.main, self.cells, self.overlay)
        for renderer in renderers:
            renderer.SetDraw(renderer in chosen)
        window = render_window(self._plotter)
        window.Render()
        window.WaitForCompletion()
        for renderer in renderers:
            renderer.DrawOn()

    def _stretch(self) -> None:
        """Before the main renderer draws: spread a coarse backdrop, drawn in the lower left, over the window."""
        if self._coarse_size is None:
            return
        window = opengl_window(self.main)
        state, frame, copy = window.GetState(), window.GetRenderFramebuffer(), self._copy
        part, whole = (0, 0, *self._coarse_size), (0, 0, *self.size)
        state.PushFramebufferBindings()
        copy.SetContext(window)
        if tuple(copy.GetLastSize()) != self._coarse_size:
            copy.PopulateFramebuffer(*self._coarse_size, True, 1, VTK_UNSIGNED_CHAR, False, 0, 0)
        state.vtkglDisable(_GL_SCISSOR_TEST)
        for source, target, rectangle, how in (
            (frame, copy, part, _GL_NEAREST),
            (copy, frame, whole, _GL_LINEAR),
        ):
            source.Bind(_GL_READ_FRAMEBUFFER)
            source.ActivateReadBuffer(0)
            target.Bind(_GL_DRAW_FRAMEBUFFER)
            target.ActivateDrawBuffer(0)
            state.vtkglBlitFramebuffer(*part, *rectangle, _GL_COLOR_BUFFER_BIT, how)
        state.PopFramebufferBindings()


def render_window(plotter: pv.BasePlotter) -> vtkRenderWindow:
    """The VTK window of an open plotter."""
    window: vtkRenderWindow | None = plotter.render_window
    if window is None:
        raise RuntimeError("the plotter is closed")
    return window


def opengl_window(renderer: vtkRenderer) -> vtkOpenGLRenderWindow:
    """The window of a renderer that is being drawn."""
    window = renderer.GetRenderWindow()
    assert isinstance(window, vtkOpenGLRenderWindow)
    return window


def props_of(renderer: vtkRenderer) -> list[vtkProp]:
    """Everything that a renderer may show, visible or not."""
    props = renderer.GetViewProps()
    return [cast(vtkProp, props.GetItemAsObject(row)) for row in range(props.GetNumberOfItems())]
