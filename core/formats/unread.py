"""Account for every field of a foreign file: those that no reader used are named in the report.

A field whose name may mean a pose, lens, region, rate, unit or kind of sensor is named with its value, because a rig
read without it may be wrong; of other fields only the names are listed. Entries of a list that are alike count as one:
a field that is used in one of them is known. Whole entries of a list that a reader passes over are its own to report.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from riglens.core.formats.report import Notes
from riglens.core.rig.yaml.nodes import shortened

Key = str | int
MOST = 30
"""Remarks on fields; the names of further ones are listed together."""
_MATTERS = re.compile(
    # pose
    r"pose|posit|rotat|transl|orient|extrin|transf|offset|roll|pitch|yaw|rpy|euler|quat|origin|mount|frame|baseline"
    r"|ax[ei]s|relat|locat|angle|heading|tilt|mirror|(^|_)([xyz]|[tq][wxyz]|[tr])(_|$)|_to_|2"
    # lens and region
    r"|lens|dist|intrin|fish|focal|fov|view|(^|_)([fc][xyuv]|[kpds][0-9]?|xi|alpha|beta)(_|$)|skew|model|project|rectif"
    r"|camera|roi|region|binning|crop|image|width|height|resol|scale|pixel|size|apert|matrix|coef"
    # rate and time
    r"|rate|hz|freq|time|delay|fps|expos|shutter|period|sync|latency|integration"
    # units and conventions
    r"|unit|deg|rad|met(er|re)|(^|_)[mc]?m(_|$)|millimet|convention|handed"
    # kinds and rays of sensors
    r"|type|kind|sensor|modalit|manufact|vendor|maker|device|beam|channel|ring|range|min|max|sonar|radar|lidar|enabled"
)
_HARMLESS = re.compile(
    r"comment|descri|date|stamp|seq|token|uuid|hash|version|author|operator|file|folder|path|url|topic|error|rms|score"
    r"|nframes|board|square|flags|calibration_time|calib_time|quality|visual|material|colou?r|serial|covar|noise|plugin"
    r"|display|always_on|update_rate|rviz|debug|id(_|$)|names?(_|$)"
)
"""Fields of these names change neither where a sensor stands nor what it sees, whatever else their names hold."""

_ZERO = re.compile(r"[-+]?0+(\.0*)?|[Ff]alse")
"""A value that says that there is nothing: its name is enough."""
_SHAPE = "rows|cols|dt"
"""Fields of a matrix as OpenCV writes it."""


class Unread(NamedTuple):
    """A field that was not used: what it is in, its name and its value."""

    parent: str
    name: str
    value: str


class Reads:
    """Record of which fields of the documents of a rig were used."""

    def __init__(self) -> None:
        self._roots: list[Any] = []
        self._used: dict[int, set[Key]] = {}

    def add(self, root: Any) -> None:
        """Take a document whose fields are to be accounted for."""
        self._roots.append(root)

    def forget(self) -> None:
        """Begin anew: what was looked at to recognise a format is not used yet."""
        self._used.clear()

    def use(self, holder: Any, key: Key) -> bool:
        """Note that a field of a mapping, or entry of a list, is used; return whether that is new."""
        known = self._used.setdefault(id(holder), set())
        if key in known:
            return False
        known.add(key)
        return True

    def unread(self) -> list[Unread]:
        """Return the fields that no reader used, in the order of the files."""
        known: set[tuple[Key, ...]] = set()
        found = [one for root in self._roots for one in self._walk(root, (), "", known)]
        return [
            Unread(parent, str(path[-1]), _shown(raw)) for path, parent, raw in found if path not in known
        ]

    def _walk(
        self, raw: Any, path: tuple[Key, ...], parent: str, known: set[tuple[Key, ...]]
    ) -> Iterator[tuple[tuple[Key, ...], str, Any]]:
        """Yield path, parent and value of unused fields; add the paths of used ones to `known`."""
        used = self._used.get(id(raw), set())
        if isinstance(raw, dict):
            for key, inner in raw.items():
                place = (*path, str(key))
                if key in used or str(key) in used:
                    known.add(place)
                    yield from self._walk(inner, place, f"{parent}.{key}" if parent else str(key), known)
                elif inner not in (None, "", [], {}, ()) and used:
                    yield place, parent, inner
        elif isinstance(raw, (list, tuple)):
            for index in sorted(used):
                assert isinstance(index, int)
                yield from self._walk(raw[index], (*path, 0), parent, known)


def note_unread(reads: Reads, notes: Notes, harmless: str = "") -> None:
    """Report the unused fields of all documents; `harmless` matches names that a format knows to bear on nothing."""
    named = {part for remark in notes.report("").of_kind("ignored") for part in remark.about}
    report_unread((one for one in reads.unread() if one.name not in named), notes, harmless)


_COMMENT = re.compile(r"#[^\n]{0,400}|<!--.{0,2000}?-->|//[^\n]{0,400}", re.DOTALL)
_OTHER_AXES = re.compile(
    r"\by\b[^\n,;.]{0,20}\bright\b|left[- ]handed|\bz\b[^\n,;.]{0,20}\bdown\b|\b(ned|frd)\b", re.IGNORECASE
)
_SEARCHED = 200_000


def note_comments(text: str, notes: Notes) -> None:
    """Report comments that speak of axes other than x forward, y left, z up: only a reader can tell what they mean."""
    for comment in _COMMENT.finditer(text[:_SEARCHED]):
        if found := _OTHER_AXES.search(comment[0]):
            words = " ".join(found[0].split())
            notes.approximated(
                f"a comment says '{shortened(words, 40)}': read with x forward, y left, z up as the format has it"
            )
            return


def report_unread(found: Iterator[Unread], notes: Notes, harmless: str = "") -> None:
    """Report unused fields: with values those that may matter, up to MOST of them, and the names of others."""
    more: list[str] = []
    said: set[tuple[str, str]] = set()
    for one in found:
        words = _words(one.name)
        is_known = re.fullmatch(f"{_SHAPE}|{harmless}" if harmless else _SHAPE, one.name)
        matters = _MATTERS.search(words) or _is_vector(one.value)
        if is_known or _HARMLESS.search(words) or _ZERO.fullmatch(one.value) or not matters:
            if not is_known:
                more.append(shortened(one.name, 40))
        elif len(said | {one[1:]}) > MOST:
            more.append(shortened(one.name, 40))
        else:
            said.add(one[1:])
            notes.ignored(
                f"field '{shortened(one.name, 40)}' is not used: {one.value}",
                *filter(None, [shortened(one.parent, 80)]),
            )
    if more:
        names = list(dict.fromkeys(more))
        rest = [f"{len(names) - MOST} more"] if len(names) > MOST else []
        notes.ignored("other fields are not used", *names[:MOST], *rest)


def _words(name: str) -> str:
    """Return a name in lower case with words set apart: `distCoeffs` as dist_coeffs."""
    return re.sub(r"[^a-z0-9]+", "_", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower())


def _is_vector(value: str) -> bool:
    return value.startswith("[") and value[1:2] in "-.0123456789["


def _shown(raw: Any) -> str:
    """Return a value on one line, shortened."""
    if isinstance(raw, dict):
        return (
            "{"
            + shortened(", ".join(f"{key}: {_shown(inner)}" for key, inner in list(raw.items())[:6]), 60)
            + "}"
        )
    if isinstance(raw, (list, tuple)):
        return "[" + shortened(", ".join(_shown(inner) for inner in raw[:12]), 60) + "]"
    return shortened(f"{raw:g}" if isinstance(raw, float) else str(raw), 40)
