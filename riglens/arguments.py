"""Arguments of the Python API: paths, and warnings about what was read."""

from __future__ import annotations

import os
from pathlib import Path

StrPath = str | os.PathLike[str]


class RigLensWarning(UserWarning):
    """Something to know about data or a rig that were read: what does not count, was approximated or left out."""


def path_of(path: StrPath | None) -> Path | None:
    """A path as the code below takes it."""
    return None if path is None else Path(path)
