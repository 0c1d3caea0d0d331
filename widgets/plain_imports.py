"""Turns off what PySide6 does at every import."""

from __future__ import annotations

import builtins


def use_plain_imports() -> None:
    """Have `import` be what it was before PySide6 put a function of its own in its place, and kept the other one.

    That function reads the whole source of every module that is imported, to see which ones use PySide6 and might ask
    for its methods in snake_case. RigLens never asks, and the reading takes a tenth of the time of a start.
    """
    builtins.__import__ = getattr(builtins, "__orig_import__", builtins.__import__)
