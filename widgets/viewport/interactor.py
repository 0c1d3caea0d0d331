"""pyvistaqt's QtInteractor, with the classes of Qt that it uses and no others.

pyvistaqt takes Qt from qtpy, which makes every class and every enumeration of Qt ready when it is imported: a fifth of
a second. PySide6 makes each when it is first asked for.
"""

from __future__ import annotations

from PySide6 import QtCore, QtGui, QtOpenGLWidgets, QtWidgets

from riglens.widgets.stand_ins import StandIn, standing_in
from riglens.widgets.viewport.drawing_half import load_drawing_half

load_drawing_half()
with standing_in(
    StandIn("qtpy.QtCore", QtCore),
    StandIn("qtpy.QtGui", QtGui),
    StandIn("qtpy.QtWidgets", QtWidgets, QtGui),  # QAction has moved since Qt 5
    StandIn("qtpy.QtOpenGLWidgets", QtOpenGLWidgets),
):
    from pyvistaqt import QtInteractor

__all__ = ["QtInteractor"]
