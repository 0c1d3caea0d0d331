"""Modules that stand where others would be while a third module is imported that names them and hardly uses them.

pyvista and pyvistaqt import packages for which RigLens has no use, and loading those takes longer than all its own
modules. The standard library's LazyLoader does not help: an import statement makes it load its module.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType


class StandIn(ModuleType):
    """Has the names it is given and those of its `lenders`; for any other it loads the module that it stands for."""

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
        """The module itself, with all of its package: a real one does not get along with stand-ins."""
        package = self.__name__.partition(".")[0]
        for name, module in list(sys.modules.items()):
            if isinstance(module, StandIn) and name.partition(".")[0] == package:
                del sys.modules[name]
        return import_module(self.__name__)


def when_called(module: str, name: str) -> Callable[..., object]:
    """A function or class of a module that is loaded when it is called."""

    def call(*values: object, **named: object) -> object:
        return getattr(import_module(module), name)(*values, **named)

    return call


@contextmanager
def standing_in(*stand_ins: StandIn) -> Iterator[None]:
    """Have imports find these, but for modules that are loaded already; later imports find the real ones."""
    placed = [stand_in for stand_in in stand_ins if stand_in.__name__ not in sys.modules]
    sys.modules.update({stand_in.__name__: stand_in for stand_in in placed})
    try:
        yield
    finally:
        for stand_in in placed:
            if sys.modules.get(stand_in.__name__) is stand_in:
                del sys.modules[stand_in.__name__]
