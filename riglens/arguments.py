"""Arguments of the Python API: paths, warnings, and their names in messages that the command line shares."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from riglens.core.errors import InputError

StrPath = str | os.PathLike[str]
_ARGUMENTS = {
    "--ground auto": "find_ground",
    "--boxes": "boxes",
    "--voxel": "voxel_m",
    "--roi": "roi_m",
    "--origin": "origin_m",
    "--frames": "frames",
    "--classes": "classes",
    "--ground": "find_ground",
    "--pog": "pog",
    "--lambda": "camera_weight",
    "--threads": "threads",
    "--body": "body",
    "--to": "target_format",
    "--out": "out",
    "--size": "size_px",
    "--scale": "scale",
    "--heatmap": "heatmap",
    "--baseline": "baseline",
    "--within": "within_m",
    "--min-points": "min_points",
    "--sample": "sample",
    "--seed": "seed",
}
"""Options of the command line, which messages name, and the arguments here."""
_OPTION = re.compile("|".join(rf"(?<![^\s(])(?:{name})(?=$|[\s:,;?)]|\.(?:\s|$))" for name in _ARGUMENTS))
"""An option as a word of its own, not as a piece of a path such as /data/--out/a.csv."""


class RigLensWarning(UserWarning):
    """Something to know about data or a rig that were read: what does not count, was approximated or left out."""


def path_of(path: StrPath | None) -> Path | None:
    """A path as the code below takes it."""
    return None if path is None else Path(path)


@contextmanager
def argument_names(*given: object) -> Iterator[None]:
    """Have an InputError of the block name arguments where it names options of the command line.

    What the user has `given`, such as the name of a file, stays as it is.
    """
    try:
        yield
    except InputError as error:
        kept = sorted({str(value) for value in given if value is not None and "--" in str(value)}, key=len)
        named = re.compile("|".join([*map(re.escape, reversed(kept)), _OPTION.pattern]))
        text = named.sub(lambda found: found[0] if found[0] in kept else _ARGUMENTS[found[0]], str(error))
        raise InputError(text) from error
