"""The text of a report: the templates in `report/`, filled from one document, for browsers and for print.

Whatever is put into a template is escaped, and written out where it has no width or steers the terminal or the reader.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from riglens.app.studies.report_document import ReportDocument
from riglens.core.errors import InputError
from riglens.core.review.blind import HEIGHTS_M
from riglens.core.rig.library import default_library
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import visible
from riglens.core.targets.card_text import HEADINGS, bearing_text

Figures = dict[str, Any]
FEW_ROWS, SHORT = 14, 40
"""Rows of a table that is not cut by the end of a page, and letters of a cell that is not broken into lines."""
PAGE_PX, PICTURE_PX = 660, 528
"""Width of printed text and charts in the units of its layout, of which an inch has 96."""
NEVER = "never"


def percent(value: Any) -> str:
    """A fraction as percent with two decimals."""
    return f"{100.0 * float(value):.2f} %"


def square_metres(value: Any) -> str:
    """An area with one decimal."""
    return f"{float(value):.1f} m²"


def thousand_nat(value: Any) -> str:
    """Nats as 10³ nat with two decimals."""
    return f"{float(value) / 1e3:,.2f}"


def number_text(value: Any) -> str:
    """A number with up to four digits behind the point."""
    return f"{float(value):.4f}".rstrip("0").rstrip(".")


def plain(value: Any) -> str:
    """Whatever it is, as text."""
    return visible(str(value))


def first_text(first_m: Any, to_m: float) -> str:
    """Least, median and most, once where they are the same; > the farthest distance tried, never where never enough."""
    if first_m["max"] == 0.0:
        return NEVER
    texts = [
        f">{to_m:g}" if first_m[key] is None else f"{first_m[key]:.0f}" for key in ("min", "median", "max")
    ]
    return texts[0] if len(set(texts)) == 1 else "-".join(texts)


def at(figures: Figures, path: str) -> Any:
    """Return the figure at a path such as rigs/0/blind/zones/0/share_seen_10m."""
    value: Any = figures
    for part in path.split("/"):
        value = value[int(part)] if isinstance(value, list) else value[part]
    return value


def report_page(document: ReportDocument) -> str:
    """Return the page for browsers; equal documents give equal text."""
    return _filled("report.html", document=document, figures=document.figures, printed=False)


def printed_page(document: ReportDocument) -> tuple[str, dict[str, bytes]]:
    """Return the same for print, and the pictures that it names: PNG and SVG."""
    pictures = {}
    for number, drawn in enumerate(document.drawings):
        pictures[f"card{number}"], pictures[f"blind{number}"] = drawn.card_png, drawn.blind_png
        pictures[f"plans{number}"] = _filled("plans.svg", plans=drawn.plans, printed=True).encode("utf-8")
    text = _filled("report.html", document=document, figures=document.figures, printed=True)
    return text, pictures


def _filled(template: str, **context: Any) -> str:
    return _templates().get_template(template).render(context)


@cache
def _templates() -> Environment:
    made = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "report"),
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
        "bearing_text": bearing_text,
        "numeral": lambda value: f"{value:g}",
        "sha256": lambda text: hashlib.sha256(text.encode("utf-8")).hexdigest(),
    }
    writers = (percent, square_metres, thousand_nat, number_text, plain)
    made.globals |= {write.__name__: write for write in writers} | {
        "at": at, "body_text": body_text, "card_lines": _card_lines, "origin": origin, "zone_places": _zone_places,
        "first_within": lambda to_m: partial(first_text, to_m=to_m),
        "classes": list(CLASSES), "heights_m": HEIGHTS_M, "few_rows": FEW_ROWS, "short": SHORT,
        "entropy_titles": [f"{name} {what}" for name in CLASSES for what in ("seen", "S-MS")],
        "page_px": PAGE_PX, "picture_px": PICTURE_PX,
    }  # fmt: skip
    return made


def _shown(value: Any) -> Any:
    """A text from outside as it may be shown; what is marked as HTML stays."""
    return visible(value) if isinstance(value, str) and not hasattr(value, "__html__") else value


def _card_lines(rows: list[dict[str, Any]]) -> Iterator[tuple[str, list[str]]]:
    """Titles of the lines of first distances, each with the places of its figures among the rows."""
    for cls, heading in dict.fromkeys((row["class"], row["heading_deg"]) for row in rows):
        for kind, words in (("lidar", "LiDARs"), ("camera", "cameras")):
            places = [n for n, row in enumerate(rows) if (row["class"], row["heading_deg"]) == (cls, heading)]
            yield f"{cls} {HEADINGS[heading]}, {words}", [f"{place}/{kind}" for place in places]


def _zone_places(zones: list[dict[str, Any]]) -> list[int]:
    """Places of the zones that have a column."""
    columns = (("any", 1), ("any", 2), ("lidar", 1), ("camera", 1))
    return [
        next(n for n, zone in enumerate(zones) if (zone["by"], zone["sensors"]) == one) for one in columns
    ]


def body_text(evaluation: Figures) -> str:
    """Return the body mode of all rigs, or of each where they differ."""
    each = (f"{rig['body']} for {rig['name']}" for rig in evaluation["rigs"] if "body" in rig)
    return str(evaluation["body"] or ", ".join(each))


def origin(model: str) -> str:
    """Return in one line where the data of a sensor model come from."""
    try:
        return "; ".join(default_library().entry(model).origin().splitlines())
    except InputError:
        return "not in the library"
