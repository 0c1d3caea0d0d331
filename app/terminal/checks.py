"""Verdicts on requirements in the terminal, and as annotations that GitHub shows beside the file of requirements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from datetime import date

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.core.review.check_junit import RigCheck
from riglens.core.review.findings import Status, Verdict
from riglens.core.shown_text import visible

MARKS: dict[Status, tuple[str, str]] = {
    "met": ("met", "green"),
    "not met": ("NOT MET", "bold red"),
    "not shown": ("NOT SHOWN", "bold red"),
    "not applicable": ("NOT APPLICABLE", "bold red"),
}


def verdict_table(verdicts: Sequence[Verdict], day: date | None) -> Table:
    """Requirements as rows: the figure and the limit, and whether it holds; below them what explains it."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for title in ("", "requirement"):
        table.add_column(title)
    for title in ("found", "accepted"):
        table.add_column(title, justify="right", no_wrap=True)
    for verdict in verdicts:
        table.add_row(_mark(verdict, day), _words(verdict, day), verdict.found_text, verdict.accepted_text)
    return table


def _mark(verdict: Verdict, day: date | None) -> Text:
    word, style = MARKS[verdict.status]
    if verdict.is_waived_on(day):
        return Text(f"{word} (waived)", "yellow")
    return Text("not applicable", "dim") if verdict.passes and verdict.status != "met" else Text(word, style)


def _words(verdict: Verdict, day: date | None) -> Text:
    one = verdict.item.requirement
    named = " ".join(word for word in (one.id, one.label) if word is not None)
    words = Text(visible(f"{named}: {verdict.text}" if named else verdict.text))
    for line in verdict.lines(day):
        words.append(f"\n  {visible(line)}", "dim")
    return words


def github_lines(checks: Sequence[RigCheck], file: str, lines: Mapping[str, int], day: date) -> Iterator[str]:
    """Workflow commands of GitHub: an error for what does not hold, a warning for what is waived."""
    for check in checks:
        for verdict in check.verdicts:
            if verdict.holds_on(day) and not verdict.is_waived_on(day):
                continue
            level = "warning" if verdict.is_waived_on(day) else "error"
            title = f"{check.rig.name}: {verdict.item.id} {verdict.status}"
            said = f"{verdict.text}: {verdict.found_text}, {verdict.accepted_text}"
            message = "\n".join(visible(line) for line in (said, *verdict.lines(day)))
            place = f"file={_property(file)},line={lines[verdict.item.id]},title={_property(title)}"
            yield f"::{level} {place}::{_escaped(message)}"


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _escaped(visible(text)).replace(":", "%3A").replace(",", "%2C")
