"""Make no machine code of a kernel that another one calls; it is part of its caller's.

Numba makes optimised machine code and two wrappers of every function, also of one that it then links into its caller
and optimises there again; a parallel loop is optimised four times. Most of that code never runs, and it took half of
the time. Here, only what Python calls is made into machine code, when all that it calls is known. A large function is
not optimised before it is linked either. A small one is: that takes little time, and its callers run up to a tenth
faster. None of this changes a result: without fast-math, LLVM keeps every rounding. All of it holds while a kernel is
compiled, under Numba's lock, and for no other function.

Python's search for unreachable cycles, which walks through all that Numba keeps, is made seldom meanwhile: it took a
fifth of the time.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import llvmlite.binding
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.targetconfig import ConfigStack

SMALL_BYTES = 30_000
"""Bitcode from which on a function is large, about a thousand instructions. Our choice: the limit, of six tried, at
which tilted cameras are cast fastest."""

COLLECT_AFTER = 100_000
"""New objects after which Python looks for unreachable cycles while a kernel is compiled; at most 700 otherwise. Our
choice."""


def is_for_a_caller() -> bool:
    """Return whether a function is at this moment compiled, or loaded, for another that is compiled."""
    return bool(ConfigStack())


class LinkedLibrary(JITCodeLibrary):  # type: ignore[misc]
    """The code of one function, without machine code if it is only linked into others."""

    def __init__(self, codegen: Any, name: str) -> None:
        super().__init__(codegen, name)
        self.is_only_linked = len(ConfigStack()) > 1  # the function's own flags are the first

    def add_linking_library(self, library: Any) -> None:
        if isinstance(library, LinkedLibrary) and not library._finalized:
            library.is_only_linked = True
        super().add_linking_library(library)

    def _optimize_final_module(self) -> None:
        if not self.is_only_linked or len(self._final_module.as_bitcode()) < SMALL_BYTES:
            super()._optimize_final_module()

    def _finalize_final_module(self) -> None:
        if not self.is_only_linked:
            super()._finalize_final_module()
            return
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0 if self.is_only_linked else int(super().get_pointer_to_function(name))

    def serialize_using_object_code(self) -> tuple[str, str, Any]:
        if not self.is_only_linked:
            return super().serialize_using_object_code()  # type: ignore[no-any-return]
        return self.name, "bitcode", self._get_module_for_linking().as_bitcode()

    @classmethod
    def _unserialize(cls, codegen: Any, state: tuple[str, str, Any]) -> Any:
        name, kind, bitcode = state
        if kind == "object":
            return super()._unserialize(codegen, state)
        library = cls(codegen, name)
        library.is_only_linked = True
        library._final_module = llvmlite.binding.parse_bitcode(bitcode)
        library._finalize_final_module()
        return library


class KernelDispatcher(CPUDispatcher):  # type: ignore[misc]
    """Numba's dispatcher, which replaces code that is only linked when Python calls the kernel."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._compiler._customize_flags = _without_wrappers_for_a_caller

    def compile(self, sig: Any) -> Any:
        with global_compiler_lock, _linked_libraries():
            types = tuple(normalize_signature(sig)[0])
            known = self.overloads.get(types)
            if known is not None and known.library.is_only_linked and not is_for_a_caller():
                del self.overloads[types]
            return super().compile(sig)

    def add_overload(self, cres: Any) -> None:
        if cres.library.is_only_linked:  # then Python does not find it
            self.overloads[tuple(cres.signature.args)] = cres
        else:
            super().add_overload(cres)


def _without_wrappers_for_a_caller(flags: Any) -> Any:
    if is_for_a_caller():
        flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
    return flags


@contextmanager
def _linked_libraries() -> Iterator[None]:
    """Let Numba make `LinkedLibrary`s, and let functions without an address have no environment."""
    codegen = CPUDispatcher.targetdescr.target_context.codegen()
    if "set_env" in vars(codegen):
        yield
        return
    set_env = codegen.set_env

    def set_if_defined(name: str, environment: Any) -> None:
        if codegen._engine.is_symbol_defined(name):
            set_env(name, environment)

    codegen._library_class, codegen.set_env = LinkedLibrary, set_if_defined
    thresholds = gc.get_threshold()
    gc.set_threshold(COLLECT_AFTER, *thresholds[1:])
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)
        del codegen._library_class, codegen.set_env
