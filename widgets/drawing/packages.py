"""Load pyvista and pyvistaqt without the packages that they import and RigLens does not use.

pyvista imports matplotlib's figures for charts inside a scene; RigLens draws none. pyvistaqt takes Qt from qtpy, which
makes every class and enumeration of Qt ready at once, where PySide6 makes each one when it is first asked for. Neither
package has a switch for that, so while they are imported, light stand-ins take the place of these modules in
`sys.modules`. The stand-ins are gone afterwards: code that needs the real modules later gets them, also inside pyvista.

pyvista is loaded before Qt: once PySide6 is loaded, every import also reads the module's source to look for PySide6.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from importlib import import_module
from types import ModuleType

_CANVAS = "matplotlib.backends.backend_agg"


def load_pyvista() -> None:
    """Load the half of pyvista that draws, and VTK with it; best before Qt.

    Its first plotter would run `xset`, or open a window of its own, to find out whether it can draw: RigLens knows.
    """
    os.environ.setdefault("ALLOW_PLOTTING", "true")
    canvas = StandIn(_CANVAS, FigureCanvasAgg=when_called(_CANVAS, "FigureCanvasAgg"))
    with standing_in(StandIn("matplotlib.pyplot"), canvas):
        import pyvista.plotting  # noqa: F401


def pyside_as_qtpy() -> AbstractContextManager[None]:
    """Return a context in which imports of qtpy find PySide6's own modules: import pyvistaqt inside it."""
    from PySide6 import QtCore, QtGui, QtOpenGLWidgets, QtWidgets

    load_pyvista()
    return standing_in(
        StandIn("qtpy.QtCore", QtCore),
        StandIn("qtpy.QtGui", QtGui),
        StandIn("qtpy.QtWidgets", QtWidgets, QtGui),  # QAction has moved since Qt 5
        StandIn("qtpy.QtOpenGLWidgets", QtOpenGLWidgets),
    )


class StandIn(ModuleType):
    """Stand-in with the given names and those of its `lenders`; any other name loads the real module."""

    def __init__(self, name: str, *lenders: ModuleType, **given: object) -> None:
        super().__init__(name)
        self._lenders = lenders
        vars(self).update(given)

    def __getattr__(self, name: str) -> object:
        if name.startswith("__"):  # what the import machinery asks every module for
            raise AttributeError(name)
        for lender in self._lenders:
            if hasattr(lender, name):
                return getattr(lender, name)
        return getattr(self._real(), name)

    def _real(self) -> ModuleType:
        """Load the real module; all stand-ins of its package are removed, because real modules do not mix with them."""
        package = self.__name__.partition(".")[0]
        for name, module in list(sys.modules.items()):
            if isinstance(module, StandIn) and name.partition(".")[0] == package:
                del sys.modules[name]
        return import_module(self.__name__)


def when_called(module: str, name: str) -> Callable[..., object]:
    """Return a callable that loads a module's function or class when it is called."""

    def call(*values: object, **named: object) -> object:
        return getattr(import_module(module), name)(*values, **named)

    return call


@contextmanager
def standing_in(*stand_ins: StandIn) -> Iterator[None]:
    """Let imports find these instead of modules that are not loaded yet; later imports find the real ones."""
    placed = [stand_in for stand_in in stand_ins if stand_in.__name__ not in sys.modules]
    sys.modules.update({stand_in.__name__: stand_in for stand_in in placed})
    try:
        yield
    finally:
        for stand_in in placed:
            if sys.modules.get(stand_in.__name__) is stand_in:
                del sys.modules[stand_in.__name__]
