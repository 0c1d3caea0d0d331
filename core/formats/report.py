"""Report on a foreign rig: everything that was read, converted, approximated or left out, in plain words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from dataclasses import field as data_field
from typing import Literal

from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import RigFile

Kind = Literal["read", "written", "converted", "approximated", "ignored"]
KINDS: tuple[Kind, ...] = ("read", "written", "converted", "approximated", "ignored")
_NAMED = 4
"""Parts that a folded remark names."""


@dataclass(frozen=True)
class Remark:
    """One thing to know, and the sensors or parts of the file that it is about (none: the whole).

    `field` is the argument that changes it, as in `ReadOptions`.
    """

    kind: Kind
    text: str
    about: tuple[str, ...] = ()
    field: str = ""

    def sentence(self) -> str:
        """Return the remark on one line, with the names of all parts that it is about."""
        return f"{self.text} ({', '.join(self.about)})" if self.about else self.text

    def folded(self) -> str:
        """Return the remark with few names, for use next to details with all of them."""
        if len(self.about) <= _NAMED:
            return self.sentence()
        return f"{self.text} ({', '.join(self.about[:_NAMED])} …: all {len(self.about)} are in the details)"


@dataclass(frozen=True)
class Report:
    """The remarks of one import or export, those of a kind together; `title` names the format."""

    title: str
    remarks: tuple[Remark, ...]

    def lines(self, name: Callable[[str], str] = str) -> list[str]:
        """Return every remark as a line, with its kind and what changes it, under the name of a front end."""
        return [f"{remark.kind}: {remark.sentence()}{_remedy(remark, name)}" for remark in self.remarks]

    def text(self, name: Callable[[str], str] = str) -> str:
        """Return the whole report as lines for a file: the format, and under each kind its remarks with every name."""
        lines = [self.title]
        for kind in dict.fromkeys(remark.kind for remark in self.remarks):
            lines += ["", f"{kind}:"]
            for remark in self.of_kind(kind):
                lines.append(f"  {remark.text}{_remedy(remark, name)}")
                lines += [f"    {name}" for name in remark.about]
        return "\n".join([*lines, ""])

    def of_kind(self, kind: Kind) -> tuple[Remark, ...]:
        """Return the remarks of one kind."""
        return tuple(remark for remark in self.remarks if remark.kind == kind)


def _remedy(remark: Remark, name: Callable[[str], str]) -> str:
    return f"; {name(remark.field)} changes it" if remark.field else ""


@dataclass(frozen=True)
class OpenedRig:
    """A rig, the `report` on everything in the file that it was read from, and its `file` if it is a rig file."""

    rig: Rig
    report: Report | None = None
    file: RigFile | None = None


@dataclass
class Notes:
    """Collector of remarks while a file is read or written; the same text about several parts becomes one remark."""

    _about: dict[tuple[Kind, str, str], list[str]] = data_field(default_factory=dict)

    def read(self, text: str, *about: str, field: str = "") -> None:
        """Note something taken from the file into the rig."""
        self._add("read", text, about, field)

    def written(self, text: str, *about: str) -> None:
        """Note something written from the rig to the file."""
        self._add("written", text, about)

    def converted(self, text: str, *about: str) -> None:
        """Note something expressed in other axes, units or words, without loss."""
        self._add("converted", text, about)

    def approximated(self, text: str, *about: str, field: str = "") -> None:
        """Note something that one side does not know: a stated default, or the nearest that can be expressed."""
        self._add("approximated", text, about, field)

    def ignored(self, text: str, *about: str) -> None:
        """Note something that the other side cannot express and that was left out."""
        self._add("ignored", text, about)

    def report(self, title: str) -> Report:
        """Return the remarks so far, by kind and then in the order in which they came."""
        found = [Remark(kind, text, tuple(about), way) for (kind, text, way), about in self._about.items()]
        return Report(title, tuple(sorted(found, key=lambda remark: KINDS.index(remark.kind))))

    def _add(self, kind: Kind, text: str, about: Sequence[str], field: str = "") -> None:
        parts = self._about.setdefault((kind, text, field), [])
        parts.extend(part for part in about if part not in parts)
