"""Report on a foreign rig: everything that was read, converted, approximated or left out, in plain words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

Kind = Literal["read", "written", "converted", "approximated", "ignored"]
KINDS: tuple[Kind, ...] = ("read", "written", "converted", "approximated", "ignored")
_NAMED = 4
"""Parts that a folded remark names."""


@dataclass(frozen=True)
class Remark:
    """One thing to know, and the sensors or parts of the file that it is about (none: the whole).

    `option` is the option of `riglens convert` that changes it.
    """

    kind: Kind
    text: str
    about: tuple[str, ...] = ()
    option: str = ""

    def sentence(self) -> str:
        """Return the remark on one line, with the names of all parts that it is about."""
        return f"{self.text} ({', '.join(self.about)})" if self.about else self.text

    def folded(self) -> str:
        """Return the remark with few names, for where all of them stand in the details beside it."""
        if len(self.about) <= _NAMED:
            return self.sentence()
        return f"{self.text} ({', '.join(self.about[:_NAMED])} …: all {len(self.about)} are in the details)"


@dataclass(frozen=True)
class Report:
    """The remarks of one import or export, those of a kind together; `title` names the format."""

    title: str
    remarks: tuple[Remark, ...]

    def lines(self) -> list[str]:
        """Return every remark as a line for the terminal, with its kind and option."""
        options = (f"; {remark.option} changes it" if remark.option else "" for remark in self.remarks)
        told = zip(self.remarks, options, strict=True)
        return [f"{remark.kind}: {remark.sentence()}{option}" for remark, option in told]

    def text(self) -> str:
        """Return the whole report as lines for a file: the format, and under each kind its remarks with every name."""
        lines = [self.title]
        for kind in dict.fromkeys(remark.kind for remark in self.remarks):
            lines += ["", f"{kind}:"]
            for remark in self.of_kind(kind):
                lines.append(f"  {remark.text}" + (f"; {remark.option} changes it" if remark.option else ""))
                lines += [f"    {name}" for name in remark.about]
        return "\n".join([*lines, ""])

    def of_kind(self, kind: Kind) -> tuple[Remark, ...]:
        """Return the remarks of one kind."""
        return tuple(remark for remark in self.remarks if remark.kind == kind)


@dataclass
class Notes:
    """Collects remarks while a file is read or written; the same text about several parts becomes one remark."""

    _about: dict[tuple[Kind, str, str], list[str]] = field(default_factory=dict)

    def read(self, text: str, *about: str, option: str = "") -> None:
        """Note something taken from the file into the rig."""
        self._add("read", text, about, option)

    def written(self, text: str, *about: str) -> None:
        """Note something written from the rig to the file."""
        self._add("written", text, about)

    def converted(self, text: str, *about: str) -> None:
        """Note something expressed in other axes, units or words, without loss."""
        self._add("converted", text, about)

    def approximated(self, text: str, *about: str, option: str = "") -> None:
        """Note something that one side does not know: a stated default, or the nearest that can be expressed."""
        self._add("approximated", text, about, option)

    def ignored(self, text: str, *about: str) -> None:
        """Note something that the other side cannot express and that was left out."""
        self._add("ignored", text, about)

    def report(self, title: str) -> Report:
        """Return the remarks so far, by kind and then in the order in which they came."""
        found = [Remark(kind, text, tuple(about), way) for (kind, text, way), about in self._about.items()]
        return Report(title, tuple(sorted(found, key=lambda remark: KINDS.index(remark.kind))))

    def has(self, words: str) -> bool:
        """Return whether any remark so far holds these words."""
        return any(words in text for _, text, _ in self._about)

    def _add(self, kind: Kind, text: str, about: Sequence[str], option: str = "") -> None:
        parts = self._about.setdefault((kind, text, option), [])
        parts.extend(part for part in about if part not in parts)
