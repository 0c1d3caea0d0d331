"""Load the objects that installed packages add by entry points: formats, kinds of sensors, figures."""

from __future__ import annotations

import logging
import multiprocessing
import operator
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, TypeVar

T = TypeVar("T")
MAX_REASON = 300
"""Characters of another program's message that are shown."""


@lru_cache
def extensions(group: str) -> tuple[tuple[str, Any], ...]:
    """Return the objects of an entry point group, each with the entry point and its distribution, for messages.

    This imports the packages. Call it when the objects are needed, never while a module is imported: the packages
    import RigLens. One that cannot be imported is reported and left out.
    """
    found = list[tuple[str, Any]]()
    for place, point in sorted((_place(point), point) for point in entry_points(group=group)):
        try:
            found.append((place, point.load()))
        except (Exception, SystemExit) as error:  # whatever a stranger's module does
            _warn(f"{place} cannot be loaded ({_reason(error)}); continuing without it")
    return tuple(found)


def extended(
    group: str,
    built_in: Mapping[str, T],
    accepted: type[T],
    beside: tuple[type, ...] = (),
    name_of: Callable[[T], str] = operator.attrgetter("name"),
) -> dict[str, T]:
    """Return the built-in objects by name, then those of the group that are of an accepted type, by `name_of`.

    A group may also hold objects of types `beside`, for another registry. One of any other type, and one whose name
    exists, is reported and left out.
    """
    found = dict(built_in)
    for place, thing in extensions(group):
        if isinstance(thing, accepted):
            name = name_of(thing)
            if name in found:
                _warn(f"{place}: the name '{name}' exists already; continuing without it")
            else:
                found[name] = thing
        elif not isinstance(thing, beside):
            _warn(
                f"{place} must be a {accepted.__name__} (got {type(thing).__name__}); continuing without it"
            )
    return found


def first_fitting(group: str, candidates: Iterable[T], fits: Callable[[T], bool]) -> T | None:
    """Return the first of some objects of a group that fits; one that raises an error is reported and passed over."""
    places = {id(thing): place for place, thing in extensions(group)}
    for candidate in candidates:
        try:
            if fits(candidate):
                return candidate
        except Exception as error:  # a broken package must not stop files of other formats
            _warn(f"{places[id(candidate)]} cannot recognise files ({_reason(error)}); passing over it")
    return None


def _place(point: EntryPoint) -> str:
    package = f"{point.dist.name} {point.dist.version}" if point.dist is not None else point.value
    return f"package {package}: '{point.name}' of {point.group}"


def _reason(error: BaseException) -> str:
    text = " ".join(f"{type(error).__name__}: {error}".split())
    return text if len(text) <= MAX_REASON else f"{text[:MAX_REASON]}…"


@lru_cache
def _warn(text: str) -> None:
    """Log a warning once, in the user's process alone: workers load the same packages."""
    if multiprocessing.parent_process() is None:
        logging.getLogger("riglens").warning("note: %s", "".join(c if c.isprintable() else "?" for c in text))
