"""The page of a report: one HTML file that needs no network, and nothing but its figures to be made.

Every number of a table is written from the attached figures, whose place stands in the cell (`data-from`).
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from html import escape
from typing import Any

from riglens.app.studies.blind_chart import blind_figure
from riglens.app.studies.pictures import picture
from riglens.app.studies.report_card import card_section
from riglens.app.studies.report_drawings import plans, view_data
from riglens.app.studies.report_figures import Report, ReportPlan
from riglens.assets import asset_path
from riglens.core.errors import InputError
from riglens.core.review.blind import HEIGHTS_M
from riglens.core.review.outline import SECTORS
from riglens.core.review.profiles import ONLY_GEOMETRY
from riglens.core.review.redundancy import COVERED
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import visible

Figures = dict[str, Any]
Write = Callable[[Any], str]
NOT_MODELLED = (
    "Rays are straight and thin: no beam divergence, no multiple returns, no rain, fog, dirt or sun.",
    "Entropy (seen, S-MS) has no occlusion by traffic; points on road users have it.",
    "Box data hold only what the recording car saw.",
    "Blind zones and redundancy are geometry: no detector, no latency, no failure rates.",
    "A built-in body is a likeness of a car of that size, not a certain model.",
)
FEW = 15
"""Rows of a table that is not cut by the end of a page, its head included."""
SHORT = 40
"""Letters of a cell that is not broken into lines."""
CSP = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"


def percent(value: Any) -> str:
    """A fraction as percent with two decimals."""
    return f"{100.0 * float(value):.2f} %"


def square_metres(value: Any) -> str:
    """An area with one decimal."""
    return f"{float(value):.1f} m²"


def thousand_nat(value: Any) -> str:
    """Nats as 10³ nat with two decimals."""
    return f"{float(value) / 1e3:,.2f}"


def plain(value: Any) -> str:
    """Whatever it is, as text."""
    return visible(str(value))


def at(figures: Figures, path: str) -> Any:
    """What stands at a path such as rigs.0.blind.zones.0.share_seen_10m; names with dots do not occur."""
    value: Any = figures
    for part in path.split("/"):
        value = value[int(part)] if isinstance(value, list) else value[part]
    return value


def report_page(plan: ReportPlan, report: Report) -> str:
    """The whole page; equal figures give equal text."""
    figures = report.figures
    title = ", ".join(visible(rig.name) for rig in plan.rigs)
    css, script = (asset_path("review", name).read_text("utf-8") for name in ("report.css", "view.js"))
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{CSP}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(title)}: sensor rig report</title><style>{css}</style></head><body>",
        f"<h1>{escape(title)}</h1>",
        f'<p class="quiet">Sensor rig report, RigLens {escape(figures["version"])}. All figures are attached to this '
        "page; <code>riglens report --verify</code> makes them again.</p>",
        *_summary(figures),
        *_scores(figures),
        *(line for number, rig in enumerate(plan.rigs) for line in _rig(plan, report, number, rig)),
        *_assumptions(figures),
        _attached("figures", figures),
        f"<script>{script}</script></body></html>",
    ]
    return "\n".join(parts) + "\n"


def _quiet(text: str) -> str:
    """A remark."""
    return f'<p class="quiet">{escape(text)}</p>'


# ---------------------------------------------------------------- tables


class _Table:
    """A table whose numbers come from the figures."""

    def __init__(self, figures: Figures, caption: str, head: Sequence[str]) -> None:
        self._figures = figures
        cells = "".join(_head(title) for title in head)
        self._lines = [f"<table><caption>{escape(caption)}</caption><thead><tr>{cells}</tr></thead>"]

    def row(self, title: str, *cells: tuple[str, Write] | str) -> None:
        """A row: its title, then places of figures with how to write them, or words."""
        written = []
        for cell in cells:
            if isinstance(cell, str):
                kind = "left short" if len(cell) <= SHORT else "left"
                written.append(f'<td class="{kind}">{escape(cell)}</td>')
            else:
                path, write = cell
                text = write(at(self._figures, path))
                written.append(f'<td data-from="{escape(path)}">{escape(text)}</td>')
        self._lines.append(f"<tr><td>{escape(title)}</td>{''.join(written)}</tr>")

    def html(self) -> str:
        """The table; one of few rows is not cut where it is printed."""
        kind = "wide few" if len(self._lines) <= FEW else "wide"
        return "".join([f'<div class="{kind}">', *self._lines, "</table></div>"])


def _head(title: str, *numbers: str) -> str:
    """The head of a column: to the left over words, to the right over numbers; those of a table of words by name."""
    is_left = title not in numbers if numbers else title in ("pair", "source", "unit", "of")
    return f'<th class="left">{escape(title)}</th>' if is_left else f"<th>{escape(title)}</th>"


def _summary(figures: Figures) -> Iterator[str]:
    checks = [rig["check"] for rig in figures["rigs"]]
    if checks[0] is None:
        yield '<p class="quiet">No requirements were given; what follows are figures without verdicts.</p>'
        return
    yield "<h2>Requirements</h2>"
    for number, check in enumerate(checks):
        failed = sum(not verdict["passes"] for verdict in check["verdicts"])
        name, count = escape(visible(check["rig"]["name"])), len(check["verdicts"])
        kind = "not" if failed else "met"
        yield f'<h3>{name}: <span class="{kind}">{count - failed} of {count} met</span></h3>'
        table = _Table(figures, "", ("requirement", "found", "", "limit", "unit", ""))
        for place, verdict in enumerate(check["verdicts"]):
            here = f"rigs/{number}/check/verdicts/{place}"
            word = "met" if verdict["passes"] else verdict["status"].upper()
            is_share = verdict["unit"] == "share"
            write, unit = (percent, "") if is_share else (number_text, verdict["unit"])
            found: tuple[str, Write] | str = "—" if verdict["found"] is None else (f"{here}/found", write)
            title = visible("; ".join([verdict["text"], *verdict["details"]]))
            table.row(title, found, verdict["relation"], (f"{here}/limit", write), unit, word)
        yield table.html()


def number_text(value: Any) -> str:
    """A number with up to four digits behind the point."""
    return f"{float(value):.4f}".rstrip("0").rstrip(".")


def _body(evaluation: Figures) -> str:
    """The body mode of all rigs, or of each where they differ."""
    each = (f"{rig['body']} for {visible(rig['name'])}" for rig in evaluation["rigs"] if "body" in rig)
    return str(evaluation["body"] or ", ".join(each))


def _scores(figures: Figures) -> Iterator[str]:
    evaluation = figures["evaluation"]
    yield "<h2>What the rig sees</h2>"
    body, reading = _body(evaluation), evaluation["reading"]
    yield _quiet(
        f"Body {body}, reading {reading}, δ {evaluation['grid']['voxel_m']:g} m. Seen: share of H(Ω), more is better; "
        "S-MS in 10³ nat, as the paper has it: with the reading covered it falls as a rig sees more."
    )
    head = ("", *(f"{name} {what}" for name in CLASSES for what in ("seen", "S-MS")))
    table = _Table(figures, "Entropy", head)
    for number, rig in enumerate(evaluation["rigs"]):
        here = f"evaluation/rigs/{number}/classes"
        cells: list[tuple[str, Write]] = []
        for name in CLASSES:
            cells += [(f"{here}/{name}/any/seen", percent), (f"{here}/{name}/s_ms", thousand_nat)]
        table.row(visible(rig["name"]), *cells)
    yield table.html()
    if figures["targets"] is None:
        yield '<p class="quiet">Road users were not counted: a stored POG has none.</p>'
        return
    for name in CLASSES:
        head = ("", "on target", "≥ 5 points", "median points", "visible", "by both", "by neither")
        table = _Table(figures, f"Road users: {name} (by neither: less is better; all others: more)", head)
        for number, rig in enumerate(figures["targets"]["rigs"]):
            here = f"targets/rigs/{number}/classes/{name}"
            table.row(
                visible(rig["name"]), (f"{here}/lidar/on_target", percent), (f"{here}/lidar/share_5", percent),
                (f"{here}/lidar/median_points", plain), (f"{here}/camera/visible", percent), (f"{here}/both", percent),
                (f"{here}/neither", percent),
            )  # fmt: skip
        yield table.html()


def _rig(plan: ReportPlan, report: Report, number: int, rig: Rig) -> Iterator[str]:
    figures, mesh = report.figures, plan.meshes[number]
    yield f"<h2>{escape(visible(rig.name))}</h2>"
    words = "From above (ahead is up) and from the left; numbers are those of the table of sensors."
    yield f"<figure>{plans(rig, mesh)}<figcaption>{words}</figcaption></figure>"
    yield (
        f'<figure data-view="view{number}"><canvas></canvas>'
        '<figcaption class="turn">Drag to turn, scroll to come closer.</figcaption></figure>'
    )
    yield _attached(f"view{number}", view_data(rig, mesh))
    yield _sensors(rig)
    yield from card_section(report, number, partial(_Table, figures))
    yield from _blind(figures, report, number)
    yield from _redundancy(figures, number)
    yield from _tolerance(figures, number)


def _sensors(rig: Rig) -> str:
    head = ("", "sensor", "kind", "model", "x, y, z (m)", "roll, pitch, yaw (°)", "rays", "fails with")
    cells = "".join(_head(title, "rays") for title in head)
    rows, sources = [], {}
    for number, sensor in enumerate(rig.sensors, 1):
        name = sensor.name if sensor.enabled else f"{sensor.name} (off)"
        words = (
            str(number), visible(name), sensor.kind, visible(sensor.model or "-"),
            ", ".join(f"{v:g}" for v in sensor.position), ", ".join(f"{v:g}" for v in sensor.rpy_deg),
            f"{sensor.ray_count:,}",
            visible(", ".join(sensor.fails_with or ())) or "-",
        )  # fmt: skip
        rows.append("<tr>" + "".join(f'<td class="left">{escape(word)}</td>' for word in words) + "</tr>")
        if sensor.model:
            sources[sensor.model] = _origin(sensor.model)
    told = "".join(
        f"<li>{escape(visible(m))}: {escape(visible(text))}</li>" for m, text in sorted(sources.items())
    )
    listed = f'<ul class="quiet">{told}</ul>' if told else ""
    head_row = f"<caption>Sensors</caption><thead><tr>{cells}</tr></thead>"
    return f'<div class="wide"><table>{head_row}{"".join(rows)}</table></div>{listed}'


def _origin(model: str) -> str:
    try:
        return "; ".join(default_library().entry(model).origin().splitlines())
    except InputError:
        return "not in the library"


def _blind(figures: Figures, report: Report, number: int) -> Iterator[str]:
    here = f"rigs/{number}/blind"
    yield "<h3>Blind zones</h3>"
    drawn = picture(blind_figure(report.maps[number], "any", 1))
    encoded = base64.b64encode(drawn).decode("ascii")
    alt = "Map of the heights from which objects are seen"
    yield f'<figure><img alt="{alt}" src="data:image/png;base64,{encoded}"></figure>'
    table = _Table(
        figures,
        "Ground where an object stands unseen; less is better",
        ("height", "by 1 sensor", "by 2", "by LiDARs", "by cameras"),
    )
    zones = at(figures, f"{here}/zones")
    order = [
        next(i for i, z in enumerate(zones) if (z["by"], z["sensors"]) == key)
        for key in (("any", 1), ("any", 2), ("lidar", 1), ("camera", 1))
    ]
    for place, height in enumerate(HEIGHTS_M):
        cells = [(f"{here}/zones/{zone}/heights/{place}/unseen_m2", square_metres) for zone in order]
        table.row(f"{height:.2f} m", *cells)
    table.row(
        "ground within 10 m seen at 0.15 m",
        *((f"{here}/zones/{zone}/share_seen_10m", percent) for zone in order),
    )
    yield table.html()
    table = _Table(figures, f"Test objects: {ONLY_GEOMETRY}", ("profile", "seen", "of", "", "source"))
    for place, profile in enumerate(at(figures, f"{here}/profiles")):
        count = str(len(profile["objects"]))
        word = "all seen" if profile["passes"] else "NOT ALL"
        table.row(
            visible(profile["title"]),
            (f"{here}/profiles/{place}/seen", plain),
            count,
            word,
            visible(profile["source"]),
        )
    yield table.html()


def _redundancy(figures: Figures, number: int) -> Iterator[str]:
    yield "<h3>Redundancy</h3>"
    note = at(figures, f"rigs/{number}/redundancy/note")
    yield _quiet(f"This is {note}. Covered: more is better; lost: less is better.")
    for kind, words in (("voxels", "entropy"), ("road_users", "road users")):
        here = f"rigs/{number}/redundancy/{kind}"
        found = at(figures, here)
        if found is None:
            continue
        titles = [name if name == "two kinds" else f"by {name}" for name in COVERED]
        table = _Table(figures, f"Covered, {words}", ("", *titles))
        for name in CLASSES:
            table.row(name, *((f"{here}/classes/{name}/covered/{level}", percent) for level in COVERED))
        yield table.html()
        table = _Table(figures, f"Lost, {words}: each sensor and each group", ("fails", *CLASSES))
        for place, failure in enumerate(found["failures"]):
            if failure["what"] != "pair":
                title = visible(failure["name"]) + (" (group)" if failure["what"] == "group" else "")
                table.row(title, *((f"{here}/failures/{place}/lost/{name}", percent) for name in CLASSES))
        yield table.html()
        caption = f"Lost, {words}: worst pair of all, then what the worst pair of each sector costs there"
        table = _Table(figures, caption, ("class", "pair", "lost", *SECTORS))
        for name in CLASSES:
            worst = found["classes"][name]["worst"]["pair"]
            if worst is not None:
                cells = [
                    (f"{here}/classes/{name}/worst_by_sector/pair/{s}/lost", percent)
                    for s in range(len(SECTORS))
                ]
                table.row(
                    name, visible(worst["name"]), (f"{here}/classes/{name}/worst/pair/lost", percent), *cells
                )
        yield table.html()


def _tolerance(figures: Figures, number: int) -> Iterator[str]:
    found = at(figures, f"rigs/{number}/tolerance")
    if found is None:
        return
    profile = found["profile"]
    yield "<h3>Tolerance</h3>"
    yield _quiet(
        f"Errors of every sensor within ± {profile['position_mm']:g} mm and ± {profile['angle_deg']:g}° "
        f"({profile['source']}), {found['draws']} draws, seed {found['seed']}. Noise floor: 1 mm, 0.01°. "
        "More is better."
    )
    head = ("figure", "as designed", "median", "5 %", "95 %", "worst", "floor 5 %", "floor 95 %")
    table = _Table(figures, "Spread", head)
    for name in found["figures"]:
        here = f"rigs/{number}/tolerance/figures/{name}"
        floor = f"rigs/{number}/tolerance/noise_floor/{name}"
        paths = [f"{here}/{key}" for key in ("nominal", "median", "p05", "p95", "worst")]
        title = name.replace("_", " ")
        table.row(title, *((path, percent) for path in (*paths, f"{floor}/p05", f"{floor}/p95")))
    yield table.html()


def _assumptions(figures: Figures) -> Iterator[str]:
    evaluation, inputs = figures["evaluation"], figures["inputs"]
    yield "<h2>What this rests on</h2><ul>"
    for line in NOT_MODELLED:
        yield f"<li>{escape(line)}</li>"
    yield "</ul><h3>Inputs</h3><ul>"
    data = evaluation["data"]
    name = visible(inputs["boxes"] or data["source"])
    yield f"<li>data: {escape(name)}, {data['frames']:,} frames, SHA-256 <code>{escape(data['sha256'])}</code></li>"
    for rig in evaluation["rigs"]:
        yield f"<li>rig {escape(visible(rig['name']))}: SHA-256 <code>{escape(rig['sha256'])}</code></li>"
    if inputs["requirements"] is not None:
        digest = hashlib.sha256(inputs["requirements"].encode("utf-8")).hexdigest()
        yield f"<li>requirements: SHA-256 <code>{digest}</code></li>"
    yield (
        f"<li>method {inputs['method']}, λ {inputs['lambda']:g}, body {escape(_body(evaluation))}, "
        f"draws {inputs['draws']}, seed {inputs['seed']}, RigLens {escape(figures['version'])}</li></ul>"
    )
    for note in data["notes"]:
        yield f'<p class="quiet">{escape(visible(note))}</p>'


def _attached(name: str, data: Any) -> str:
    """Data inside the page, in which nothing can end the script element or begin another."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    for letter in "<>&\u2028\u2029":
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return f'<script type="application/json" id="{name}">{text}</script>'


def attached_figures(page: str, where: str) -> Figures:
    """The figures attached to a page, or on their own as a PDF holds them; InputError when it is no report."""
    begin = page.find('<script type="application/json" id="figures">')
    end = page.find("</script>", begin)
    is_bare = page.lstrip().startswith("{")
    if not is_bare and (begin < 0 or end < 0):
        raise InputError(f"{where}: found no attached figures; accepted is a page made by riglens report")
    try:
        found = json.loads(page if is_bare else page[page.index(">", begin) + 1 : end])
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where}: the attached figures are damaged") from error
    if not isinstance(found, dict) or found.get("riglens_report") != 1:
        raise InputError(f"{where}: found no report of version 1, which is what this program reads")
    return found
