"""Arguments of the Python interface: paths, vectors, classes of boxes, and warnings about what was read."""

from __future__ import annotations

import inspect
import os
import sys
import warnings
from collections.abc import Callable, Mapping
from functools import wraps
from inspect import Parameter
from pathlib import Path
from typing import Any, Literal, ParamSpec, TypedDict, TypeVar, Unpack

from numpy.typing import ArrayLike

from riglens.core.compiler import require_compiler
from riglens.core.errors import InputError
from riglens.core.geometry import triple
from riglens.core.monitor import Monitor
from riglens.core.scene.boxes import DataReport
from riglens.core.sensors.registry import kind_named, kind_names
from riglens.core.shown_text import remark_text
from riglens.evaluation.names import argument_with
from riglens.evaluation.options import SceneOptions

P = ParamSpec("P")
R = TypeVar("R")
StrPath = str | os.PathLike[str]
ClassName = Literal["car", "bicycle", "pedestrian"]


class RigLensWarning(UserWarning):
    """Remark on data or a rig that was read: boxes that do not count, values that were approximated or left out."""


def warn(line: str) -> None:
    """Warn at the line of the caller's own code."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_globals.get("__name__", "").split(".")[0] == "riglens":
        frame, level = frame.f_back, level + 1
    warnings.warn(remark_text(line), RigLensWarning, stacklevel=level)


class Warnings(Monitor):
    """Listener of one call from Python: each remark is a warning, once."""

    def __init__(self) -> None:
        self._noted = set[str]()

    def note(self, line: str) -> None:
        """Warn at the line of the caller's own code."""
        if line not in self._noted:
            self._noted.add(line)
            warn(line)

    def advice(self, field: str, value: object) -> str:
        """Return an argument."""
        return argument_with(field, value)


def warn_of_data(data: DataReport) -> None:
    """Warn of what is implausible about data, of boxes that do not count and of classes without any."""
    from riglens.evaluation.scenario import remarks_on

    for line in remarks_on(data, argument_with):
        warn(line)


def require_kind(kind: str | None) -> None:
    """Raise InputError for a kind of sensor that there is not: it would choose none, in silence."""
    if kind is not None and kind_named(kind) is None:
        raise InputError(f"must be {' or '.join(kind_names())} (got {kind})", "kind")


class BoxReading(TypedDict, total=False):
    """Arguments of how boxes are read, of every function that reads them; defaults are those of `SceneOptions`."""

    origin_m: ArrayLike | None
    frames: int | None
    classes: Mapping[str, str] | None
    find_ground: bool


def reads_boxes(function: Callable[P, R]) -> Callable[P, R]:
    """Show a function, whose last parameter is `**read_as`, with every argument of `BoxReading` in its place,
    to editors and help(); one that is misspelt is named."""
    signature, usual = inspect.signature(function), SceneOptions()
    *stated, _ = signature.parameters.values()
    for name, kind in BoxReading.__annotations__.items():
        words = getattr(kind, "__forward_arg__", kind)
        stated.append(Parameter(name, Parameter.KEYWORD_ONLY, default=getattr(usual, name), annotation=words))
    shown = signature.replace(parameters=stated)

    @wraps(function)
    def run(*inputs: P.args, **given: P.kwargs) -> R:
        shown.bind(*inputs, **given)
        return function(*inputs, **given)

    run.__signature__ = shown  # type: ignore[attr-defined]
    return run


def scene_options(
    boxes: StrPath | None,
    *,
    voxel_m: float | None = None,
    roi_m: ArrayLike | None = None,
    pog: StrPath | None = None,
    surroundings: bool = False,
    occluders: tuple[StrPath, StrPath] | None = None,
    **read_as: Unpack[BoxReading],
) -> SceneOptions:
    """Return the options of the command line for these arguments."""
    require_compiler()
    read = dict[str, Any](read_as)
    if read.get("origin_m") is not None:
        read["origin_m"] = triple(read["origin_m"])
    read["classes"] = tuple(f"{name}={cls}" for name, cls in dict(read.get("classes") or {}).items())
    return SceneOptions(
        boxes=None if boxes is None else Path(boxes),
        voxel_m=voxel_m,
        roi_m=None if roi_m is None else triple(roi_m),
        pog=None if pog is None else Path(pog),
        surroundings=surroundings or occluders is not None,
        occluders=None if occluders is None else (Path(occluders[0]), Path(occluders[1])),
        **read,
    )
