"""Detection range by class and direction: part of `riglens review`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter
from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import number, taken
from riglens.app.terminal.console import results
from riglens.app.terminal.tables import table
from riglens.core.files import require_ending, write_file
from riglens.core.shown_text import visible
from riglens.core.targets.detection_range import DetectionRange, RangePlan, RangeRow
from riglens.core.targets.detection_range_table import range_lines
from riglens.core.targets.detection_range_text import HEADINGS, bearing_text, reach_text, stop_text
from riglens.studies.files import csv_text

RANGE = Group("Detection range", sort_key=7)


RangeArguments = Annotated[
    RangePlan, taken(RANGE, "min_height_px", "to_m", "reaction_s", "deceleration_mps2")
]


@Parameter(name="*")
@dataclass(frozen=True)
class RangeTables:
    """Directions and files of the detection range."""

    directions: Annotated[int, number(RANGE)] = 8
    """Number of directions around the car, the first one ahead."""
    range_csv: Annotated[Path | None, Parameter(group=RANGE, metavar="FILE.csv")] = None
    """Also write the detection ranges as a table."""
    range_chart: Annotated[Path | None, Parameter(group=RANGE, metavar="FILE.png|.svg")] = None
    """Also draw a chart: distance by direction."""

    def __post_init__(self) -> None:
        require_ending("range_chart", self.range_chart, ".png", ".svg")

    @property
    def files(self) -> dict[str, Path | None]:
        """The files to write, by option."""
        return {"range_csv": self.range_csv, "range_chart": self.range_chart}

    def write(self, found: DetectionRange) -> None:
        """Write the files that were named."""
        if self.range_csv is not None:
            write_file(self.range_csv, csv_text(range_lines(found)))
        if self.range_chart is not None:
            from riglens.studies.detection_range_chart import range_figure  # matplotlib
            from riglens.studies.pictures import write_picture

            write_picture(self.range_chart, range_figure(found))


def print_range(ranges: DetectionRange) -> None:
    """Print the distances, what they mean, and the stopping distances, on standard output."""
    console = results()
    console.print(
        Text(f"{visible(ranges.rig.name)}: first distance in metres with too little"), soft_wrap=True
    )
    console.print(_table(ranges))
    for line in _explanation(ranges):
        console.print(line, soft_wrap=True)
    console.print(_stops(ranges))


def _explanation(ranges: DetectionRange) -> Iterator[str]:
    """Yield the lines that explain the figures."""
    plan = ranges.plan
    yield (
        f"LiDARs: fewer than {plan.min_points} points, as worst/median/best over the object's position between the "
        f"beams (gap {ranges.gap_deg:.2g} deg). Cameras: less than {plan.min_height_px:g} pixels tall. More is better."
    )
    yield (
        f"Alone on flat ground, body {plan.settings.as_dict()['body']}; distance from the middle of the car to "
        f"the middle of the object, up to {plan.to_m:g} m."
    )
    yield (
        f"Can stop from: speed from which the car stops before it, {plan.reaction_s:g} s of reaction and "
        f"{plan.deceleration_mps2:g} m/s2 (our choice), at the least distance."
    )


def _table(ranges: DetectionRange) -> Table:
    titles = ("object", *map(bearing_text, ranges.plan.bearings_deg), "can stop from")
    made = table(*titles, dense=True, wraps=range(len(titles)))
    rows = list(dict.fromkeys((row.cls, row.heading_deg) for row in ranges.rows))
    for cls, heading in rows:
        mine = [row for row in ranges.rows if (row.cls, row.heading_deg) == (cls, heading)]
        for kind in mine[0].reaches:
            made.add_row(f"{cls} {HEADINGS[heading]}, {kind}", *_cells(ranges, mine, kind))
    return made


def _cells(ranges: DetectionRange, rows: list[RangeRow], kind: str) -> Iterator[str]:
    ahead = ""
    for row in rows:
        reach = row.reaches[kind]
        yield reach_text(reach, ranges.plan.to_m)
        ahead = ahead or stop_text(ranges.stops_from_kmh(row, reach))
    yield ahead


def _stops(ranges: DetectionRange) -> Table:
    made = table("speed (km/h)", *(f"{speed:g}" for speed in ranges.plan.speeds_kmh), dense=True)
    made.add_row(
        "stops within (m)", *(f"{ranges.plan.stopping_m(speed):.0f}" for speed in ranges.plan.speeds_kmh)
    )
    return made
