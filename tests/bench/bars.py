"""A bar: one ratio measured inside one run, its goal, and how all of them are written and shown."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

from rich.table import Table

from riglens.core.files import atomic_write

Better = Literal["higher", "lower"]


@dataclass(frozen=True)
class Bar:
    """One line of `out/bench.json`; the times are None where something else than time is compared."""

    bar: str
    work: str
    ours_ms: float | None
    yardstick_ms: float | None
    ratio: float
    goal: float
    better: Better

    @property
    def is_reached(self) -> bool:
        """Whether the ratio is on the right side of the goal."""
        return self.ratio >= self.goal if self.better == "higher" else self.ratio <= self.goal


def write_bars(bars: list[Bar], path: Path) -> None:
    """Write the bars as a JSON list."""
    path.parent.mkdir(exist_ok=True)
    with atomic_write(path, "w") as stream:
        stream.write(json.dumps([asdict(bar) for bar in bars], indent=1) + "\n")


def bar_table(bars: list[Bar]) -> Table:
    """The bars as a table for the terminal."""
    table = Table(title="Speed and memory, each against its yardstick in the same run")
    table.add_column("bar", no_wrap=True)
    table.add_column("work", overflow="fold")
    for name in ("ours ms", "yardstick ms", "ratio", "goal"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("reached?", no_wrap=True)
    for bar in bars:
        sign = "≥" if bar.better == "higher" else "≤"
        table.add_row(
            bar.bar,
            bar.work,
            _number(bar.ours_ms),
            _number(bar.yardstick_ms),
            _number(bar.ratio),
            f"{sign} {bar.goal:,g}",
            "[green]yes[/]" if bar.is_reached else "[red]no[/]",
        )
    return table


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"
