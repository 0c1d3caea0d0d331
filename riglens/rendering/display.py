"""Detect a display, and prepare drawing without one, before Qt or VTK is loaded."""

from __future__ import annotations

import ctypes
import os
import sys

from riglens.rendering.system_libraries import require_system_libraries

_UNSEEN_PLATFORMS = ("offscreen", "minimal", "vnc")


def missing_display() -> str | None:
    """Return why no window can be opened, in a few words; None when one can."""
    if not sys.platform.startswith("linux"):
        return None
    platform = os.environ.get("QT_QPA_PLATFORM", "")
    if platform.startswith(_UNSEEN_PLATFORMS):
        return f"QT_QPA_PLATFORM is {platform}"
    name = os.environ.get("DISPLAY", "")
    if not name:
        return "DISPLAY is not set"
    return None if _answers(name) else f"DISPLAY is {name}, but nothing answers there"


def _answers(name: str) -> bool:
    """Return whether an X server accepts a connection; True without libxcb, which is reported by name later."""
    try:
        xcb = ctypes.CDLL("libxcb.so.1")
    except OSError:
        return True
    xcb.xcb_connect.restype = ctypes.c_void_p
    xcb.xcb_connect.argtypes = [ctypes.c_char_p, ctypes.c_void_p]
    xcb.xcb_connection_has_error.argtypes = [ctypes.c_void_p]
    xcb.xcb_disconnect.argtypes = [ctypes.c_void_p]
    connection = xcb.xcb_connect(os.fsencode(name), None)
    works: bool = xcb.xcb_connection_has_error(connection) == 0
    xcb.xcb_disconnect(connection)
    return works


def prepare_drawing() -> None:
    """Check the system libraries, and make VTK draw without an X server where there is none.

    Comes before anything that imports VTK: it crashes, instead of complaining, when OpenGL is absent.
    """
    require_system_libraries("offscreen")
    if sys.platform.startswith("linux") and missing_display():
        os.environ["VTK_DEFAULT_OPENGL_WINDOW"] = "vtkEGLRenderWindow"
