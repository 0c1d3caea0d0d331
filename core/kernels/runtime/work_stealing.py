"""Work stealing: threads take pieces one by one, so that a delayed thread holds back no more than its current piece.

Parallel loops give every thread its share beforehand, and all wait for the last one. Which thread does which piece
cannot matter: pieces write words of their own, or add up integers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.core import types
from numba.core.typing.templates import Signature
from numba.extending import intrinsic

from riglens.core.kernels.runtime.jit import kernel


@kernel
def new_counter() -> np.ndarray:
    """Return a counter at 0, int64 (1,). A function of its own: parallel code fills arrays in parallel."""
    return np.zeros(1, np.int64)


@intrinsic  # type: ignore[untyped-decorator]
def take(typingctx: Any, counter: Any) -> tuple[Signature, Any]:
    """Return the next piece, 0 for the first: counter[0], which grows by one in the same instruction."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        from llvmlite import ir

        array = context.make_array(signature.args[0])(context, builder, args[0])
        return builder.atomic_rmw("add", array.data, ir.Constant(ir.IntType(64), 1), "monotonic")

    return types.int64(counter), codegen
