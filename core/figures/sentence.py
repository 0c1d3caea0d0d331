"""Say in one sentence whether a rig is better than another, by the figures that lead."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from riglens.core.figures.figure import ALL, CLASSES_AND_ALL, Estimate, Figure
from riglens.core.figures.registry import leading_figures
from riglens.core.figures.text import change_estimate_text, in_sentence, verdict
from riglens.core.figures.values import Values
from riglens.core.scene.boxes import CLASSES

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.figures.evaluated import Evaluated

Changes = Mapping[str, Mapping[str, Estimate]]
"""Changes from a baseline by key of a figure, and by class or `ALL`."""


@dataclass(frozen=True)
class _Resolved:
    """A change that is better or worse for certain."""

    figure: Figure
    who: str
    change: Estimate
    is_better: bool

    def text(self, with_figure: bool = True) -> str:
        """Return figure, class and change."""
        who = () if self.who == ALL else (self.who,)
        title = (in_sentence(self.figure.title),) if with_figure else ()
        return " ".join((*title, *who, change_estimate_text(self.figure, self.change)))


def sentence(changes: Changes, baseline: str) -> str:
    """Say whether a rig is better or worse than the baseline of these changes, mixed, or not to be told apart; or why
    there is nothing to compare. Only changes count that are resolved, and beyond their error."""
    known = [changes[figure.key] for figure in _judging() if figure.key in changes]
    there = [change for by_class in known for change in by_class.values()]
    if not any(one.exists for one in there):
        reason = f": {there[0].reason}" if there else ""
        return f"Nothing to compare with {baseline}{reason}"
    if not any(one.value for one in there):
        return f"The same figures as {baseline}"
    resolved = list(_resolved(changes))
    if not resolved:
        return f"No difference from {baseline} that these figures can tell"
    ways = {one.is_better for one in resolved}
    if len(ways) == 1:
        first = _foremost(resolved)
        return f"{'Better' if first.is_better else 'Worse'} than {baseline}: {first.text()}"
    return f"Mixed against {baseline}: {_mixed(resolved)}"


def changes_of(now: Evaluated, before: Evaluated) -> Changes:
    """Return the changes of the figures that judge, from one evaluated rig to another in the same scene."""
    return {
        figure.key: {who: figure.change(now, before, who) for who in CLASSES_AND_ALL} for figure in _judging()
    }


def changes_between(now: Values, before: Values) -> Changes:
    """Return the changes of the figures that judge, from one rig's figures to another's, both of all frames."""
    keys = [figure.key for figure in _judging() if figure.key in now and figure.key in before]
    return {key: {who: found.minus(before[key][who]) for who, found in now[key].items()} for key in keys}


def _judging() -> tuple[Figure, ...]:
    """Return the leading figures of classes that have a direction."""
    return tuple(one for one in leading_figures() if one.per_class and one.better != "neither")


def _resolved(changes: Changes) -> Iterator[_Resolved]:
    for figure in _judging():
        for who in CLASSES_AND_ALL:
            change = changes.get(figure.key, {}).get(who)
            found = "" if change is None else verdict(figure, change)
            if change is not None and found in ("better", "worse"):
                yield _Resolved(figure, who, change, found == "better")


def _mixed(resolved: Sequence[_Resolved]) -> str:
    """Return the classes of the first figure where some of them gain and others lose; else its change, and the first
    one to the contrary."""
    first = resolved[0]
    mine = [one for one in resolved if one.figure is first.figure and one.who in CLASSES]
    if len({one.is_better for one in mine}) == 2:
        return ", ".join([mine[0].text(), *(one.text(with_figure=False) for one in mine[1:])])
    contrary = _foremost([one for one in resolved if one.is_better != first.is_better])
    return f"{first.text()}, but {contrary.text()}"


def _foremost(resolved: Sequence[_Resolved]) -> _Resolved:
    """Return the first change of a mean over the classes; without one the largest of a class, of the first figure."""
    mine = [one for one in resolved if one.figure is resolved[0].figure]
    largest = max(mine, key=lambda one: abs(one.change.value))
    return next((one for one in resolved if one.who == ALL), largest)
