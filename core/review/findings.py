"""Record the finding for a requirement, the verdict that follows, and both in words with the digits that decide."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date
from decimal import Decimal
from typing import Literal

from riglens.core.review.requirements import Item

Status = Literal["met", "not met", "not shown", "not applicable"]
MOST_DIGITS = 20


@dataclass(frozen=True)
class Finding:
    """Figure that a requirement limits; None if rig or scene lack its subject.

    `text` says which figure where that is known only now; bounds: of a figure that is an estimate; details: lines
    that explain the figure; is_impossible: no such rig can be built, and no permission to be missing counts; is_shown:
    whether enough was tried to say that it is within its limit.
    """

    value: float | None
    text: str | None = None
    bounds: tuple[float, float] | None = None
    details: tuple[str, ...] = ()
    is_impossible: bool = False
    is_shown: bool = True


def missing(reason: str) -> Finding:
    """Return the finding without a figure, and the reason."""
    return Finding(None, details=(reason,))


@dataclass(frozen=True)
class Verdict:
    """A requirement and what was found."""

    item: Item
    finding: Finding

    @property
    def text(self) -> str:
        """Return the figure and its subject in words."""
        return self.finding.text or self.item.requirement.text

    @property
    def status(self) -> Status:
        """Status of the requirement; an estimate meets it if both bounds do, and shows nothing if only one does."""
        if self.finding.value is None:
            return "not applicable"
        one = self.item.requirement
        low, high = self.finding.bounds or (self.finding.value, self.finding.value)
        if one.relation == "at least":
            low, high = -high, -low
        limit = one.accepted if one.relation == "at most" else -one.accepted
        if high <= limit and self.finding.is_shown:
            return "met"
        return "not met" if low > limit else "not shown"

    @property
    def passes(self) -> bool:
        """Return whether it is met, or may be missing; waivers do not count."""
        return self.status == "met" or (
            self.status == "not applicable"
            and self.item.requirement.allow_missing
            and not self.finding.is_impossible
        )

    def is_waived_on(self, day: date | None) -> bool:
        """Return whether it does not pass, and a waiver holds on a day; none holds without a day."""
        waiver = self.item.requirement.waived
        return not self.passes and waiver is not None and day is not None and waiver.holds_on(day)

    def holds_on(self, day: date | None) -> bool:
        """Return whether it counts as met on a day."""
        return self.passes or self.is_waived_on(day)

    @property
    def found_text(self) -> str:
        """Return the figure with its unit, with enough digits to tell it from the limit; a dash without one."""
        if self.finding.value is None:
            return "—"
        return amounts(self.finding.value, self.item.requirement.accepted, self.item.requirement.unit)[0]

    @property
    def accepted_text(self) -> str:
        """The limit with its unit, with as many digits as the figure."""
        one = self.item.requirement
        value = one.accepted if self.finding.value is None else self.finding.value
        return f"{one.relation} {amounts(value, one.accepted, one.unit)[1]}"

    def lines(self, day: date | None = None) -> tuple[str, ...]:
        """Return further lines: why it is required, details, its waiver."""
        one = self.item.requirement
        why = () if one.why is None or self.passes else (f"why: {one.why}",)
        empty = ("no rig can miss this limit",) if one.is_met_by_all and self.status == "met" else ()
        return (*self.finding.details, *empty, *why, *self._waiver_lines(day))

    def _waiver_lines(self, day: date | None) -> tuple[str, ...]:
        waiver = self.item.requirement.waived
        if waiver is None:
            return ()
        if self.passes:
            return ("the waiver is not needed",)
        if day is not None and waiver.is_too_long_on(day):
            return (f"the waiver ends more than two years ahead, on {waiver.until}, and does not count",)
        if day is not None and not waiver.holds_on(day):
            return (f"the waiver expired on {waiver.until}: {waiver.reason}",)
        return (f"waived until {waiver.until}: {waiver.reason}",)


def amounts(found: float, limit: float, unit: str) -> tuple[str, str]:
    """Return a figure and its limit with their unit, shares in percent, with enough digits to tell them apart."""
    if unit not in ("share", "m²"):
        return f"{found:g} {unit}", f"{limit:g} {unit}"
    scale, word = (100, "%") if unit == "share" else (1, unit)
    for digits in range(2, MOST_DIGITS + 1):
        texts = tuple(f"{scale * Decimal(value):.{digits}f}" for value in (found, limit))
        if found == limit or texts[0] != texts[1]:
            break
    return f"{texts[0]} {word}", f"{texts[1]} {word}"
