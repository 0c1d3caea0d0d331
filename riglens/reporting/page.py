"""The text of a report: the templates in `report/`, filled from one document.

Whatever is put into a template is escaped, and written out where it has no width or steers the terminal or the reader.
"""

from __future__ import annotations

import base64
import hashlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from riglens.core.blind.zones import HEIGHTS_M
from riglens.core.errors import InputError
from riglens.core.figures.figure import Figure
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import figure_named, leading_figures, object_figures
from riglens.core.figures.text import UNITS, change_unit, in_unit
from riglens.core.review.documents import settings_text
from riglens.core.review.findings import amounts
from riglens.core.review.mounts import SIDES, USUAL_LIMITS
from riglens.core.rig.library import default_library
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensing.rays import farthest_m
from riglens.core.sensors.base import Sensor
from riglens.core.sensors.registry import kind_of, kinds
from riglens.core.shown_text import visible
from riglens.core.targets.calibration import Domain
from riglens.core.targets.detection_range_text import HEADINGS, bearing_text
from riglens.reporting.document import ReportDocument
from riglens.reporting.summary import missed_objects, smallest_range, worst_failure, worst_profile

Figures = dict[str, Any]
FEW_ROWS, SHORT, MOST_MISSED = 14, 40, 40
"""Rows of a table that is not cut by the end of a page, letters of a cell that is not broken into lines, and missed
objects that are listed."""
NEVER = "never"
OUTCOMES = {
    "hits_car": "hit the car", "never_enters": "outside", "ground": "ground",
    "meets_nothing": "nothing", "seen_by_others": "shared", "brings_new": "new",
}  # fmt: skip
"""Columns of the audit: what becomes of rays."""


def percent(value: Any) -> str:
    """Return a fraction as percent with two decimals."""
    return f"{100.0 * float(value):.2f} %"


def square_metres(value: Any) -> str:
    """Return an area with one decimal."""
    return f"{float(value):.1f} m²"


def thousand_nat(value: Any) -> str:
    """Return nats as 10³ nat with two decimals."""
    return minus(f"{float(value) / 1e3:,.2f}")


def metres(value: Any) -> str:
    """Format a length with two decimals; a dash where there is none."""
    return "—" if value is None else minus(f"{float(value):.2f}")


def whole(value: Any) -> str:
    """Return a count."""
    return f"{value:,}"


def in_brackets(write: Callable[[Any], str]) -> Callable[[Any], str]:
    """Return what writes a figure that is outside of what it was shown for."""
    return lambda value: f"({write(value)})"


def minus(text: str) -> str:
    """Return a number with a true minus sign."""
    return text.replace("-", "−")


def difference_text(value: float, write: Callable[[Any], str]) -> str:
    """Return a difference with its sign, of shares in percentage points."""
    text = write(abs(value)).replace(" %", " pp")
    return f"{'−' if value < 0 else '+'}{text}"


def plain(value: Any) -> str:
    """Return any value as text."""
    return visible(str(value))


def first_text(first_m: Any, to_m: float) -> str:
    """Return worst, median and best, once if equal; ">" and the farthest distance tried, or "never", where none is
    enough."""
    if first_m["max"] == 0.0:
        return NEVER
    texts = [
        f">{to_m:g}" if first_m[key] is None else f"{first_m[key]:.0f}" for key in ("min", "median", "max")
    ]
    return texts[0] if len(set(texts)) == 1 else "/".join(texts)


def limit_texts(verdict: Figures) -> tuple[str, str]:
    """Return the finding and the limit, with their unit and the digits that tell them apart."""
    if verdict["found"] is None:
        return "—", amounts(verdict["limit"], verdict["limit"], verdict["unit"])[1]
    return amounts(verdict["found"], verdict["limit"], verdict["unit"])


def few_words(details: list[str]) -> str:
    """Return the first details of a verdict, and the number of further ones."""
    more = [f"{len(details) - 2} more"] if len(details) > 3 else []
    return "; ".join([*(details[:2] if more else details), *more])


def verdict_text(verdict: Figures) -> str:
    """Return the verdict in words; a report has no date, so waivers never count in it."""
    waived = verdict["waived"]
    word = "met" if verdict["status"] == "met" else verdict["status"].upper()
    if verdict["passes"] and verdict["status"] != "met":
        word = f"{verdict['status']}, allowed"
    return (
        word if waived is None or verdict["passes"] else f"{word}; waiver until {waived['until']} not counted"
    )


def at(figures: Figures, path: str) -> Any:
    """Return the figure at a path such as rigs/0/blind/zones/0/share_seen_10m."""
    value: Any = figures
    for part in path.split("/"):
        value = value[int(part)] if isinstance(value, list) else value[part]
    return value


def report_page(document: ReportDocument) -> str:
    """Return the page for browsers and for print; equal documents give equal text."""
    figures = document.figures
    classes = classes_in(figures)
    return (
        _templates()
        .get_template("report.html")
        .render(
            document=document,
            figures=figures,
            classes=classes,
            absent=[name for name in CLASSES if name not in classes],
            lost_titles=[f"lost: {name}" for name in classes],
        )
    )


def classes_in(figures: Figures) -> list[str]:
    """Return the classes that the data have: shares of the others would be those of nothing."""
    scored, targets = figures["evaluation"]["rigs"][0]["classes"], figures["targets"]
    counted = scored if targets is None else targets["rigs"][0]["classes"]
    return [name for name in CLASSES if scored[name]["h_total"] or counted[name].get("objects")]


@cache
def _templates() -> Environment:
    made = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        finalize=_shown,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "allow_nan": False}
    made.filters |= {
        "base64": lambda content: base64.b64encode(content).decode("ascii"),
        "bearing_text": lambda bearing: minus(bearing_text(bearing)),
        "numeral": lambda value: minus(f"{value:g}"),
        "sha256": lambda text: hashlib.sha256(text.encode("utf-8")).hexdigest(),
    }
    writers = (percent, square_metres, thousand_nat, metres, whole, plain)
    made.globals |= {write.__name__: write for write in writers} | {
        function.__name__: function
        for function in (
            at, body_text, range_lines, difference_text, few_words, gains_in, has_figure, in_brackets, leading_columns,
            limit_texts, missed_objects, object_columns, origin, reason_of, region_of, sector_columns, settings_text,
            smallest_range, verdict_text, view_text, worst_failure, worst_profile, zone_places,
        )
    } | {
        "first_within": lambda to_m: partial(first_text, to_m=to_m),
        "heights_m": HEIGHTS_M, "few_rows": FEW_ROWS, "short": SHORT,
        "most_missed": MOST_MISSED,
        "outcomes": OUTCOMES, "sides": SIDES, "usual_gap_m": USUAL_LIMITS.gap_m,
    }  # fmt: skip
    return made


def _shown(value: Any) -> Any:
    """Escape a foreign text for display; text marked as HTML stays."""
    return visible(value) if isinstance(value, str) and not hasattr(value, "__html__") else value


@dataclass(frozen=True)
class Column:
    """A figure as a column: how it is written, and where it stands in the figures of a class."""

    figure: Figure

    @property
    def title(self) -> str:
        """Its title, with the unit that cells do not repeat."""
        return f"{self.figure.title}, {UNITS['nat']}" if self.figure.unit == "nat" else self.figure.title

    @property
    def write(self) -> Callable[[Any], str]:
        """Function that writes its value."""
        writers = {"share": percent, "nat": thousand_nat, "m²": square_metres}
        return writers.get(self.figure.unit, plain)

    def place(self, rig: int, cls: str) -> str:
        """Return where the figure of a rig and class stands."""
        return f"evaluation/rigs/{rig}/classes/{cls}/figures/{self.figure.key}"

    def at(self, document: ReportDocument, rig: int, cls: str) -> Figures | None:
        """Return the figure of a rig and class; None where the rig has sensors of other kinds."""
        of_class = document.figures["evaluation"]["rigs"][rig]["classes"][cls]
        found: Figures | None = of_class["figures"].get(self.figure.key)
        return found

    def sector_path(self) -> str:
        """Return where the value stands in a sector."""
        name = self.figure.place.split(".")[-1]
        is_calibrated = isinstance(self.figure, ObjectFigure) and self.figure.calibration is not None
        return f"{name}/value" if is_calibrated else name


def leading_columns() -> list[Column]:
    """Return the leading figures."""
    return [Column(one) for one in leading_figures()]


def object_columns(document: ReportDocument, cls: str) -> list[Column]:
    """Return the other figures of objects of a class that any rig has."""
    every = [Column(one) for one in object_figures() if not one.leads]
    rigs = range(len(document.rigs))
    return [one for one in every if any(has_figure(document, one, rig, cls) for rig in rigs)]


def sector_columns() -> list[Column]:
    """Return the leading figures of objects, which are shown by sector, too."""
    return [one for one in leading_columns() if isinstance(one.figure, ObjectFigure)]


@dataclass(frozen=True)
class Gains:
    """Unit of the gains of a figure, and the function that writes one without it."""

    unit: str
    write: Callable[[Any], str]


def gains_in(key: str) -> Gains:
    """Return the unit and the writer of a figure's gains."""
    figure = figure_named(key)
    assert figure is not None, key
    return Gains(change_unit(figure), lambda gain: minus(f"{in_unit(figure, float(gain)):.2f}"))


def has_figure(document: ReportDocument, column: Column, rig: int, cls: str) -> bool:
    """Return whether a rig has a figure for a class."""
    found = column.at(document, rig, cls)
    return found is not None and found["value"] is not None


def reason_of(document: ReportDocument, column: Column, rig: int, cls: str) -> str:
    """Return why there is no figure, or why it is outside its domain."""
    found = column.at(document, rig, cls)
    return "the rig has no such sensors" if found is None else str(found["reason"] or "")


def range_lines(rows: list[Figures]) -> Iterator[tuple[str, list[str]]]:
    """Yield the titles of the lines of detection ranges, each with the places of its figures among the rows."""
    for cls, heading in dict.fromkeys((row["class"], row["heading_deg"]) for row in rows):
        places = [n for n, row in enumerate(rows) if (row["class"], row["heading_deg"]) == (cls, heading)]
        for kind in (kind for kind in kinds() if all(kind.name in rows[place] for place in places)):
            yield (
                f"{cls} {HEADINGS[heading]}, {kind.plural}",
                [f"{place}/{kind.name}" for place in places],
            )


def zone_places(zones: list[Figures]) -> list[tuple[str, int]]:
    """Return titles and places of the zones that have a column: by any sensor, by two, and by each kind."""
    place_of = {(zone["by"], zone["sensors"]): place for place, zone in enumerate(zones)}
    columns = [("by 1 sensor", "any", 1), ("by 2", "any", 2)]
    columns += [(f"by {kind.plural}", kind.name, 1) for kind in kinds()]
    return [(title, place_of[by, count]) for title, by, count in columns if (by, count) in place_of]


def view_text(sensor: Sensor) -> tuple[str, str]:
    """Return the field of view of a sensor, across and up, and its range."""
    wide, high = (
        f"{angle:.0f}" if math.isfinite(angle) else "—" for angle in kind_of(sensor).view_deg(sensor)
    )
    near, far = sensor.range_m[0], farthest_m(sensor)
    reach = "no limit" if math.isinf(far) else f"{near:g} to {far:g}"
    return f"{wide} × {high}", reach if near == 0.0 or math.isfinite(far) else f"from {near:g}"


def region_of(calibration: Figures) -> str:
    """Return the region of a calibration in words."""
    return Domain.model_validate(calibration["domain"]).region


def body_text(evaluation: Figures, names: Sequence[str]) -> str:
    """Return the body mode of all rigs, or of each by its name where they differ."""
    pairs = zip(evaluation["rigs"], names, strict=True)
    each = (f"{rig['body']} for {name}" for rig, name in pairs if "body" in rig)
    return str(evaluation["body"] or ", ".join(each))


def origin(model: str) -> str:
    """Return in one line where the data of a sensor model come from."""
    try:
        return "; ".join(default_library().entry(model).origin().splitlines())
    except InputError:
        return "not in the library"
