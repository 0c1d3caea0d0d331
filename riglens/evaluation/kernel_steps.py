"""Steps in which all kernels are compiled, and which of them are on disk. Loads no kernel."""

from __future__ import annotations

import sys

from riglens.core.kernels.runtime.jit import FOLDER

STEPS = (
    "rays",
    "maps",
    "points",
    "beams",
    "lenses",
    "blind",
    "redundancy",
    "audit",
    "range",
    "objects",
    "frame",
)
"""In the order in which a new user is likely to need them; `every_kernel` has a function for each."""
APART = ("points", "beams", "lenses")
"""Steps of a second process: half of the work, with few kernels in common with the others."""


def first(half: str) -> str:
    """Return the argument of a process that begins, at the usual priority, with half of what the open rig needs."""
    return f"--{half}-first"


def shares_of(processors: int) -> tuple[tuple[str, ...], ...]:
    """Return the steps of each process that compiles: two where there is a second processor."""
    if processors < 2:
        return (STEPS,)
    return tuple(step for step in STEPS if step not in APART), APART


def is_done(step: str) -> bool:
    """Return whether the kernels of a step are on disk, for these sources."""
    return FOLDER.read(_mark(step)) is not None


def mark_done(step: str) -> None:
    """Note that the kernels of a step are on disk."""
    FOLDER.write(_mark(step), b"")


def steps_done() -> int:
    """Count the steps whose kernels are on disk."""
    return sum(is_done(step) for step in STEPS)


def _mark(step: str) -> str:
    return f"step-{step}-{FOLDER.sources.digest}-{sys.implementation.cache_tag}"
