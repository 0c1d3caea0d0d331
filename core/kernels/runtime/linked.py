"""Make no machine code of a kernel that another one calls; it is part of its caller's.

Numba makes optimised machine code and two wrappers of every function, also of one that it then links into its caller
and optimises there again; a parallel loop is optimised four times. Most of that code never runs, and it took half of
the time. Here, only what Python calls is made into machine code, when all that it calls is known. A large function is
not optimised before it is linked either. A small one is: that takes little time, and its callers run up to a tenth
faster. None of this changes a result: without fast-math, LLVM keeps every rounding. All of it holds while a kernel is
compiled, under Numba's lock, and for no other function but Numba's own that a kernel calls.

Two thirds of the time is Numba's own Python, so passes that change no kernel are left out, options of functions are
compared by what is set rather than by every default, and Python's search for unreachable cycles, which walks through
all that Numba keeps, is made seldom.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import llvmlite.binding
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.targetconfig import ConfigStack
from numba.core.types.misc import unliteral

SMALL_BYTES = 30_000
"""Bitcode from which on a function is large, about a thousand instructions. Our choice: the limit, of six tried, at
which tilted cameras are cast fastest."""

COLLECT_AFTER = 100_000
"""New objects after which Python looks for unreachable cycles while a kernel is compiled; at most 700 otherwise. Our
choice."""

NEEDLESS = frozenset(
    (
        "WithLifting",
        "RewriteDynamicRaises",
        "MakeFunctionToJitFunction",
        "InlineInlinables",
        "FindLiterallyCalls",
        "LiteralUnroll",
        "LiteralPropagationSubPipelinePass",
        "InlineOverloads",
        "NoPythonSupportedFeatureValidation",
        "AnnotateTypes",
        "DumpParforDiagnostics",
    )
)
"""Passes for what no kernel has: contexts, closures, exceptions with values, functions inlined by Numba, literals that
are asked for; checks of features, and reports."""


class KernelCompiler(CompilerBase):  # type: ignore[misc]
    """Numba's compiler without needless passes; it looks for branches that are never taken once, not three times."""

    def define_pipelines(self) -> list[PassManager]:
        manager, names = PassManager("kernel"), set[str]()
        for one, description in DefaultPassBuilder.define_nopython_pipeline(self.state).passes:
            if one.__name__ not in NEEDLESS and (
                one.__name__ != "DeadBranchPrune" or one.__name__ not in names
            ):
                manager.add_pass(one, description)
            names.add(one.__name__)
        manager.finalize()
        return [manager]


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
    """Numba's dispatcher, which replaces code that is only linked when Python calls the kernel, and compiles no code of
    its own for every number that a caller writes as an argument: LLVM does where it inlines."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, pipeline_class=KernelCompiler, **named)

    def compile(self, sig: Any) -> Any:
        with global_compiler_lock, _linked_libraries():
            types = tuple(unliteral(one) for one in normalize_signature(sig)[0])
            known = self.overloads.get(types)
            if known is not None and known.library.is_only_linked and not is_for_a_caller():
                del self.overloads[types]
            return super().compile(types)

    def add_overload(self, cres: Any) -> None:
        if cres.library.is_only_linked:  # then Python does not find it
            self.overloads[tuple(cres.signature.args)] = cres
        else:
            super().add_overload(cres)


class KernelFlags(Flags):  # type: ignore[misc]
    """Numba's options of a function, compared by what is set: its own look at every default, ten thousands of times."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Flags) and bool(self._values == other._values)

    def __hash__(self) -> int:
        return hash(frozenset(self._values))


def _without_wrappers(_compiler: Any, flags: Flags) -> KernelFlags:
    """Leave out what only C calls, and for a caller's function also what only Python calls."""
    flags.no_cfunc_wrapper, flags.no_cpython_wrapper = True, is_for_a_caller()
    return KernelFlags(flags)


@contextmanager
def _linked_libraries() -> Iterator[None]:
    """Let Numba make `LinkedLibrary`s, let functions without an address have no environment, and save what takes
    time."""
    codegen = CPUDispatcher.targetdescr.target_context.codegen()
    if "set_env" in vars(codegen):
        yield
        return
    set_env = codegen.set_env

    def set_if_defined(name: str, environment: Any) -> None:
        if codegen._engine.is_symbol_defined(name):
            set_env(name, environment)

    codegen._library_class, codegen.set_env = LinkedLibrary, set_if_defined
    usual, _FunctionCompiler._customize_flags = _FunctionCompiler._customize_flags, _without_wrappers
    thresholds = gc.get_threshold()
    gc.set_threshold(COLLECT_AFTER, *thresholds[1:])
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)
        _FunctionCompiler._customize_flags = usual
        del codegen._library_class, codegen.set_env
