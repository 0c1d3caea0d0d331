"""The text of a report: the templates in `report/`, filled from one document.

Whatever is put into a template is escaped, and written out where it has no width or steers the terminal or the reader.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from riglens.core.blind.zones import HEIGHTS_M
from riglens.core.errors import InputError
from riglens.core.figures.figure import Estimate, Figure
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import figure_named, leading_figures, object_figures
from riglens.core.figures.text import UNITS, change_unit, in_unit
from riglens.core.review.documents import settings_text
from riglens.core.review.findings import amounts
from riglens.core.review.mounts import SIDES
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensing.rays import farthest_m
from riglens.core.sensors.base import Sensor
from riglens.core.sensors.registry import kind_of, kinds
from riglens.core.shown_text import visible
from riglens.core.targets.calibration import Domain
from riglens.core.targets.detection_range_text import HEADINGS, bearing_text
from riglens.reporting.charts import (
    FEW_OBJECTS,
    SPEEDS_KMH,
    blind_areas,
    estimate_of,
    missed_wheel,
    range_chart,
)
from riglens.reporting.document import ReportDocument
from riglens.reporting.plans import NARROW_DEG
from riglens.reporting.summary import (
    NO_BREAK,
    change_words,
    estimate_words,
    headline,
    leading_of,
    missed_objects,
    subjects,
    worst_cards,
)
from riglens.reporting.svg import DARK, GAIN, INK, LINE, LOSS_TEXT, PANEL, PAPER, SOFT, Drawing

Figures = dict[str, Any]
FEW_ROWS, MANY_ROWS, SHORT = 14, 18, 40
"""Rows of a table that is not cut by the end of a page, rows above which a table is set close, and letters of a cell
that is not broken into lines."""
NEVER = "never"
OUTCOMES = {
    "hits_car": "hit the car", "never_enters": "miss the region", "ground": "end at ground",
    "meets_nothing": "hit nothing", "seen_by_others": "seen by others", "brings_new": "unique",
}  # fmt: skip
"""Columns of the audit: what becomes of rays."""


def percent(value: Any) -> str:
    """Return a fraction as percent with one decimal."""
    return f"{_fixed(100.0 * float(value), 1)} %"


def square_metres(value: Any) -> str:
    """Return an area with one decimal."""
    return f"{_fixed(float(value), 1)} m²"


def hidden_on(area_m2: Any) -> str:
    """Return in words on how much ground an object is hidden."""
    if not area_m2:
        return "nowhere"
    return f"on {square_metres(area_m2)}" if area_m2 >= 0.05 else "on less than 0.1 m²"


def thousand_nat(value: Any) -> str:
    """Return nats as 10³ nat with two decimals."""
    return _fixed(float(value) / 1e3, 2)


def metres(value: Any) -> str:
    """Format a length with two decimals; a dash where there is none."""
    return "—" if value is None else _fixed(float(value), 2)


def whole(value: Any) -> str:
    """Return a count, or a median of counts, without decimals."""
    return _fixed(value, 0)


def _fixed(value: float, places: int) -> str:
    """Return a number with some decimals and a true minus sign; zero has none."""
    return minus(f"{round(value, places) + 0.0:,.{places}f}")


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


GLOSSARY = (
    ("Body", "blocks: rays end at the car's own body and housings; ignored: they pass through it."),
    (
        "Detected",
        "5 LiDAR points or more, half of the silhouette in a picture, or a return of another kind of sensor.",
    ),
    (
        "Silhouette",
        "what a camera would show of an object with nothing in front of it and a picture without edges.",
    ),
    (
        "Pixels per metre",
        "of an upright board; EN 62676-4: 25 to detect, 63 to observe, 125 to recognise, 250 to identify.",
    ),
    ("Blind", "no ray passes through an object of that height at that place."),
    ("Detection range", "first distance with too few points or pixels on one object alone in the open."),
    ("Stopping distance", "distance of reaction and braking; the appendix states the assumptions."),
    (
        "Entropy",
        "uncertainty of where objects are, summed over voxels, in nat; seen: the share that rays traverse.",
    ),
    ("S-MS", "score of the paper on camera and LiDAR placement (ICRA 2024); it falls as coverage grows."),
    ("±", "two standard errors; about 95 of 100 samples are closer to the exact value."),
)


def sensors_text(rig: Rig) -> str:
    """Return the number of enabled sensors of each kind, and of those that are off."""
    enabled = [sensor.kind for sensor in rig.sensors if sensor.enabled]
    counts = [(enabled.count(kind.name), kind) for kind in kinds()]
    words = [f"{count} {kind.title if count == 1 else kind.plural}" for count, kind in counts if count]
    off = len(rig.sensors) - len(enabled)
    return ", ".join([*words, *([f"{off} off"] if off else [])]) or "none"


def models_in(document: ReportDocument) -> list[str]:
    """Return the sensor models of all rigs, each once."""
    return sorted({sensor.model for rig in document.rigs for sensor in rig.sensors if sensor.model})


def profiles_in(document: ReportDocument) -> list[tuple[str, str]]:
    """Return titles and sources of the profiles of test objects, each once."""
    every = (profile for rig in document.figures["rigs"] for profile in rig["blind"]["profiles"])
    return list(dict.fromkeys((profile["title"], profile["source"]) for profile in every))


def near_and_far(
    document: ReportDocument, number: int, classes: Sequence[str]
) -> tuple[Drawing, list[tuple[str, Drawing]], list[tuple[str, Drawing]], list[Figures], str]:
    """Return the drawings of page 3 that are made of figures alone: blind areas, ranges and missed objects by class,
    with the stopping distances that they show and a legend of the lines."""
    key, shape = f"rig{number + 1}", document.drawings[number].shape
    rig, first = document.figures["rigs"][number], document.figures["rigs"][0] if number else None
    heights = [
        (f"rigs/{number}/blind/zones/0/heights/{place}/unseen_m2", one)
        for place, one in enumerate(rig["blind"]["zones"][0]["heights"])
    ]
    areas = blind_areas(key, heights, first and first["blind"]["zones"][0]["heights"])
    rows = rig["range"]["rigs"][0]["rows"]
    there = [kind.plural for kind in kinds() if any(kind.name in row for row in rows)]
    ranged = list(dict.fromkeys(row["class"] for row in rows)) if there else []
    before = first and first["range"]
    charts = [(cls, range_chart(key, cls, rig["range"], before, shape)) for cls in ranged]
    wheels = [] if rig["missed"] is None else [
        (cls, missed_wheel(key, cls, rig["missed"], bool(number), shape)) for cls in classes
    ]  # fmt: skip
    stops = [one for one in rig["range"]["stopping"]["distances"] if one["speed_kmh"] in SPEEDS_KMH]
    lines = zip(there, ("solid", "dashed", "dotted", "dash-dotted"), strict=False)
    return areas, charts, wheels, stops, "; ".join(f"{name}: {line}" for name, line in lines) + "."


class SensorRow(NamedTuple):
    """Texts of a sensor's row, and where its footprint and its mount stand among the figures of the rig."""

    position: str
    angles: str
    view: str
    pixels: str
    footprint: int | None
    mount: int | None
    remarks: str


def sensor_row(rig: Rig, figures: Figures, place: int) -> SensorRow:
    """Return the row of a sensor."""
    sensor = rig.sensors[place]
    footprints, mounts = figures["footprint"]["sensors"], figures["mounts"]["mounts"]
    footprint = next((n for n, one in enumerate(footprints) if one["name"] == sensor.name), None)
    tall = [
        one["height_px"]
        for one in (() if footprint is None else footprints[footprint].get("pixels_on", ()))
        if one["class"] == "pedestrian" and one["distance_m"] <= 50.0
    ]
    pixels = "/".join("—" if px is None else f"{px:.0f}" for px in tall)
    said = (one["text"] for one in figures["mounts"]["violations"] if one["sensor"] == sensor.name)
    broken = (text.split(" must be ")[0] for text in said)
    return SensorRow(
        ", ".join(_fixed(value, 2) for value in sensor.position),
        ", ".join(_fixed(value, 1) for value in sensor.rpy_deg),
        view_text(sensor), pixels or "—", footprint,
        next((n for n, one in enumerate(mounts) if one["name"] == sensor.name), None),
        "; ".join(broken),
    )  # fmt: skip


def _dark_style() -> Markup:
    """Return the rules that give a dark page its colours, drawings included."""
    named = {
        "ink": INK,
        "quiet": SOFT,
        "line": LINE,
        "panel": PANEL,
        "paper": PAPER,
        "good": GAIN,
        "bad": LOSS_TEXT,
    }
    root = "; ".join(f"--{name}: {DARK[colour]}" for name, colour in named.items())
    drawn = " ".join(
        f'[{part}="{light}"] {{ {part}: {dark} }}'
        for light, dark in DARK.items()
        for part in ("fill", "stroke")
    )
    return Markup(f"@media screen and (prefers-color-scheme: dark) {{ :root {{ {root} }} {drawn} }}")


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
            subjects=subjects(document),
            dark_style=_dark_style(),
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
        "bearing_text": bearing_text,
        "sha256": lambda text: hashlib.sha256(text.encode("utf-8")).hexdigest(),
    }
    writers = (percent, square_metres, hidden_on, metres, whole, plain)
    made.globals |= {write.__name__: write for write in writers} | {
        function.__name__: function
        for function in (
            at, body_text, range_lines, change_of, change_words, estimate_of, estimate_words, few_words, gains_in,
            has_figure, headline, leading_columns, leading_of, limit_texts, missed_objects, models_in,
            near_and_far, ranges_text, object_columns, origin, profiles_in, reason_of, region_of, remarks_in,
            sector_columns, sensor_row, sensors_text, settings_text, spread_title, titles_of, verdict_text,
            worst_cards, zone_places,
        )
    } | {
        "first_within": lambda to_m: partial(first_text, to_m=to_m),
        "heights_m": HEIGHTS_M, "few_rows": FEW_ROWS, "many_rows": MANY_ROWS, "short": SHORT,
        "few_objects": FEW_OBJECTS, "narrow_deg": NARROW_DEG, "glossary": GLOSSARY,
        "outcomes": OUTCOMES, "sides": SIDES,
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
        """Its title, with the unit that cells do not repeat on the same line as the last word."""
        unit = UNITS[self.figure.unit]
        return f"{self.figure.title},{NO_BREAK}{unit}" if unit != "points" else self.figure.title

    @property
    def write(self) -> Callable[[Any], str]:
        """Function that writes its value."""
        writers = {"share": percent, "nat": thousand_nat, "m": metres, "m²": square_metres}
        return writers.get(self.figure.unit, whole)

    def place(self, rig: int, cls: str) -> str:
        """Return where the figure of a rig and class stands."""
        return f"evaluation/rigs/{rig}/classes/{cls}/figures/{self.figure.key}"

    def at(self, document: ReportDocument, rig: int, cls: str) -> Figures | None:
        """Return the figure of a rig and class; None where the rig has sensors of other kinds."""
        of_class = document.figures["evaluation"]["rigs"][rig]["classes"][cls]
        found: Figures | None = of_class["figures"].get(self.figure.key)
        return found

    @property
    def sector_name(self) -> str:
        """Return its name in a sector."""
        return self.figure.place.split(".")[-1]

    def in_sector(self, document: ReportDocument, rig: int, cls: str, sector: Figures) -> Estimate:
        """Return the figure of a rig and class in a sector, in the state that it has for the class."""
        found, whole = sector[self.sector_name], self.at(document, rig, cls)
        if whole is None or whole["value"] is None or found is None or not sector["objects"]:
            return Estimate.none("")
        value, se = (found["value"], found["se"]) if isinstance(found, dict) else (found, 0.0)
        return Estimate(value, se, whole["state"])


def leading_columns() -> list[Column]:
    """Return the leading figures."""
    return [Column(one) for one in leading_figures()]


def object_columns(document: ReportDocument, classes: Sequence[str]) -> list[Column]:
    """Return the other figures of objects that any rig has of any of the classes."""
    every = [Column(one) for one in object_figures() if not one.leads]
    places = list(product(range(len(document.rigs)), classes))
    return [one for one in every if any(has_figure(document, one, *place) for place in places)]


def change_of(document: ReportDocument, column: Column, rig: int, cls: str) -> str:
    """Return how a figure of a class differs from that of the first rig, with the error of the change if it has one."""
    against = document.figures["rigs"][rig]["against"]
    change = estimate_of(None if against is None else against["changes"].get(column.figure.key, {}).get(cls))
    if change.se:
        return change_words(column.figure, change)
    now, first = (at(document.figures, f"{column.place(one, cls)}/value") for one in (rig, 0))
    return difference_text(now - first, column.write)


def spread_title(name: str) -> str:
    """Return the title of a figure of the tolerance, which is named by its key and its class."""
    key, _, cls = name.rpartition(" ")
    figure = figure_named(key)
    return name if figure is None else f"{figure.title}, {cls}"


def titles_of(counts: Sequence[tuple[str, str]], titles: Sequence[str]) -> list[str]:
    """Return the titles of columns for each of what is counted, which is named where there are several."""
    return [title if len(counts) == 1 else f"{what}: {title}" for _, what in counts for title in titles]


def remarks_in(violations: Sequence[Figures]) -> list[tuple[str, list[str]]]:
    """Return each rule on mounts that is broken with the sensors that break it, and by what."""
    found: dict[str, list[str]] = {}
    for one in violations:
        rule, _, value = one["text"].partition(" (is ")
        found.setdefault(rule, []).append(f"{one['sensor']} ({value}" if value else one["sensor"])
    return list(found.items())


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


def view_text(sensor: Sensor) -> str:
    """Return the field of view of a sensor, across and up, in degrees."""
    angles = kind_of(sensor).view_deg(sensor)
    return " × ".join(f"{angle:.0f}" if math.isfinite(angle) else "—" for angle in angles)


def ranges_text(rig: Rig) -> str:
    """Return the ranges of a rig's sensors, each with the models, or kinds of sensors without one, that have it."""
    models: dict[str, list[str]] = {}
    for sensor in rig.sensors:
        near, far = sensor.range_m[0], farthest_m(sensor)
        reach = f"{near:g} to {far:g} m" if math.isfinite(far) else f"from {near:g} m" if near else "no limit"
        models.setdefault(reach, []).append(sensor.model or kind_of(sensor).plural)
    return (
        "; ".join(f"{', '.join(dict.fromkeys(names))} {reach}" for reach, names in models.items())
        or "no sensor"
    )


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
