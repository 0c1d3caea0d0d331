"""The leading figures of rigs as a table for the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.terminal.console import results
from riglens.core.figures.evaluated import Evaluated
from riglens.core.figures.figure import ALL, CLASSES_AND_ALL, Estimate, Figure
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import leading_figures
from riglens.core.figures.sentence import changes_of, sentence
from riglens.core.figures.text import UNITS, estimate_text, in_sentence, parts_text
from riglens.core.figures.weakest import FEWEST, weakest_by_class, weakest_text
from riglens.core.shown_text import numbered, visible


def leading_table(rigs: Sequence[Evaluated]) -> Iterator[Table | str]:
    """Yield a table of the leading figures, rigs as rows, with a section for the mean of the classes and one per class,
    and the lines that explain it."""
    wanted, made = leading_figures(), Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 2, 0, 0))
    made.add_column("", no_wrap=True, overflow="ellipsis", max_width=28)
    for figure in wanted:
        unit = f", {UNITS[figure.unit]}" if figure.unit == "nat" else ""
        made.add_column(f"{figure.title}{unit}", justify="right")
    reasons, titles = dict[str, None](), numbered([visible(rig.rig.name) for rig in rigs])
    for name in CLASSES_AND_ALL:
        made.add_row(Text("class mean" if name == ALL else name, "bold"))
        of_row = [one for one in wanted if name != ALL or one.needs == "objects"]
        for rig, title in zip(rigs, titles, strict=True):
            found = {figure: figure.of(rig, name) for figure in of_row}
            cells = (_cell(one, found[one]) if one in found else "" for one in wanted)
            made.add_row(Text(f"  {title}"), *cells)
            for figure, one in found.items():
                if one.reason:
                    outside = "outside its domain: " if one.state == "outside" else ""
                    reasons[f"{title}: {figure.title}: {outside}{one.reason}."] = None
        made.add_section()
    yield made
    for rig, title in zip(rigs[1:], titles[1:], strict=True):
        yield f"{title}: {sentence(changes_of(rig, rigs[0]), titles[0])}."
    for rig, title in zip(rigs, titles, strict=True):
        yield from _weakest(rig, title)
    if any(rig.objects is not None for rig in rigs):
        yield f"Worst: of classes and sectors with at least {FEWEST} objects."
    for figure in wanted:
        yield f"{figure.title}: {in_sentence(figure.tip)} Of {figure.region(rigs[0])}."
    yield from reasons


def _weakest(rig: Evaluated, title: str) -> Iterator[str]:
    """Yield where each figure of objects is worst, in the mean of the classes."""
    for figure in leading_figures():
        if rig.objects is not None and isinstance(figure, ObjectFigure):
            said = weakest_text(figure, weakest_by_class(figure, rig.objects)[ALL])
            if said:
                yield f"{title}: {in_sentence(figure.title)}, {said}."


def print_leading(rigs: Sequence[Evaluated]) -> None:
    """Print the leading figures of rigs on standard output."""
    for part in leading_table(rigs):
        results().print(part, soft_wrap=isinstance(part, str))


def _cell(figure: Figure, found: Estimate) -> Text:
    """Return a figure and its parts, in brackets where it is outside its domain."""
    shown = "\n".join(filter(None, (estimate_text(figure, found), parts_text(figure, found))))
    return Text(f"({shown})", "dim") if found.state == "outside" else Text(shown)
