"""Check that kernels may be compiled, without loading the compiler."""

from __future__ import annotations

import os

from riglens.core.errors import InputError

SWITCH = "NUMBA_DISABLE_JIT"


def require_compiler() -> None:
    """Raise InputError where the environment switches Numba's compiler off: some kernels are no Python at all."""
    if os.environ.get(SWITCH, "0").strip() not in ("", "0"):
        raise InputError(
            f"{SWITCH}={os.environ[SWITCH]}: nothing can be computed without the compiler; unset it"
        )
