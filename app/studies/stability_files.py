"""The files of the stability study: both parts as CSV, and one HTML page, self-contained and fit for printing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from riglens.app.studies.files import csv_text
from riglens.app.studies.stability_text import (
    READING_THE_TABLE,
    TITLES,
    Cell,
    Finding,
    Line,
    caption,
    conclusion,
    findings,
    lines,
    methods_verdict,
    setting_text,
)
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.stability_methods import METHODS, MethodRow, Outcome
from riglens.core.study.stability_metric import LETTERS, MetricStudy, Ranking, agreement


def methods_csv(rows: Sequence[MethodRow]) -> str:
    """Return part 1 as CSV: per method the verdict, its result, and voxels found, missed and extra."""
    return csv_text([_method_line(row) for row in rows])


def metric_csv(study: MetricStudy) -> str:
    """Part 2 as CSV, full precision: a line per setting and class; every resample on its own."""
    settings = [("default", "", study.reference)]
    settings += [(varied.axis, setting_text(varied), varied.ranking) for varied in study.variations]
    settings += [("frames", f"resample {n}", drawn) for n, drawn in enumerate(study.resamples, 1)]
    return csv_text([_metric_line(*setting, study, cls) for setting in settings for cls in CLASSES])


def _method_line(row: MethodRow) -> dict[str, object]:
    line: dict[str, object] = {"case": row.case, "why": row.why, "rays": _shown(row.rays), "exact": row.exact}
    for method in METHODS:
        outcome = row.outcomes[method]
        line |= {f"{method}_verdict": outcome.verdict, f"{method}_says": outcome.text}
        counts = {"voxels": outcome.voxels, "missed": outcome.missed, "extra": outcome.extra}
        line |= {f"{method}_{name}": _shown(count) for name, count in counts.items()}
    return line


def _metric_line(
    axis: str, setting: str, ranking: Ranking, study: MetricStudy, cls: str
) -> dict[str, object]:
    found = agreement(ranking, study.reference, cls)
    line: dict[str, object] = {"varied": axis, "setting": setting, "class": cls}
    line |= {"kendall_tau": _shown(found.tau), "spearman_rho": _shown(found.rho)}
    line |= {f"order_{of}": " < ".join(ranking.order(of, cls)) for of in ("lidars", "cameras", "rigs")}
    line |= {f"s_mig_{letter}": repr(ranking.s_mig[letter][cls]) for letter in LETTERS}
    line |= {f"s_ms_{rig}": repr(s_ms) for rig, s_ms in ranking.figures("rigs", cls).items()}
    return line


def _shown(value: float | None) -> object:
    return "" if value is None else value


# ---------------------------------------------------------------- the page


STYLE = """
:root { --ink: #1c2126; --dim: #5d6873; --line: #d9dee3; --good: #1f7a45; --bad: #b3261e; --wash: #f5f7f9; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2.5rem 2rem 4rem; max-width: 76rem; color: var(--ink); background: #fff;
  font: 15px/1.5 system-ui, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif; }
h1 { margin: 0 0 .3rem; font-size: 1.75rem; line-height: 1.2; letter-spacing: -.01em; }
h2 { margin: 2.8rem 0 .6rem; font-size: 1.25rem; }
p { max-width: 60rem; margin: .4rem 0 .8rem; }
.dim { color: var(--dim); }
ul { max-width: 60rem; padding-left: 1.1rem; }
li { margin: .25rem 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th { text-align: left; font-weight: 600; padding: .35rem .7rem; border-bottom: 2px solid var(--ink);
  vertical-align: bottom; white-space: nowrap; }
td { padding: .38rem .7rem; border-bottom: 1px solid var(--line); vertical-align: top; }
th.n, td.n { text-align: right; white-space: nowrap; }
th.c, td.c { text-align: center; white-space: nowrap; }
td.name { font-weight: 600; white-space: nowrap; }
td.name span { display: block; max-width: 30rem; font-weight: 400; font-size: 12.5px; color: var(--dim);
  white-space: normal; }
td.ok { color: var(--good); white-space: nowrap; }
td.fails { color: var(--bad); background: #fdf1f0; font-weight: 600; white-space: nowrap; }
td.whole { white-space: nowrap; }
td.none { color: #a4adb6; }
td.first, th.first { border-left: 1px solid var(--line); }
td.letters { font-family: ui-monospace, "DejaVu Sans Mono", monospace; white-space: nowrap; }
td.other { color: var(--bad); font-weight: 600; }
tr.default td { background: var(--wash); font-weight: 600; }
@media print { body { padding: 0; font-size: 11px; } table { font-size: 10px; } tr { break-inside: avoid; } }
"""


def page(rows: Sequence[MethodRow], study: MetricStudy, source: str) -> str:
    """Both parts of the study as an HTML document; `source` is the data set's name."""
    parts = [
        "<h1>How stable are the methods, and the metric?</h1>",
        f'<p class="dim">{escape(caption(study, source))}</p>',
        "<h2>1. Methods: cases that break simple ones</h2>",
        "<p>Every voxel counts in these cases. The right answer comes from rational arithmetic. A method "
        "fails when it misses a voxel that a ray runs through, or adds one that no ray runs through. The plain "
        "method is DDA in doubles, voxel by voxel; where no rays are compared, the obvious implementation.</p>",
        _list(methods_verdict(rows)),
        _methods(rows),
        "<h2>2. The metric: what it promises on this scene</h2>",
        _findings(findings(study)),
        _list(conclusion(study)),
        "<h2>3. Orders of the paper’s eight rigs</h2>",
        f"<p>{escape(READING_THE_TABLE)} Red: another order than by default.</p>",
        _orders(lines(study)),
    ]
    body = "\n".join(parts)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>RigLens: stability</title>\n<style>{STYLE}</style>\n</head>\n"
        f"<body>\n{body}\n</body>\n</html>\n"
    )


def _list(sentences: Iterable[str]) -> str:
    items = "\n".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return f"<ul>\n{items}\n</ul>" if items else ""


def _table(head: str, rows: Iterable[str]) -> str:
    body = "\n".join(f"{row}" for row in rows)
    return f'<div class="wide"><table>\n<thead>{head}</thead>\n<tbody>\n{body}\n</tbody>\n</table></div>'


def _methods(rows: Iterable[MethodRow]) -> str:
    titles = "".join(f"<th>{TITLES[method]}</th>" for method in METHODS)
    head = f'<tr><th>case</th><th class="n">rays</th><th>exact</th>{titles}</tr>'
    return _table(head, (_method_row(row) for row in rows))


def _method_row(row: MethodRow) -> str:
    rays = "" if row.rays is None else f"{row.rays:,}"
    cells = "".join(_outcome(row.outcomes[method]) for method in METHODS)
    name = f"{escape(row.case)}<span>{escape(row.why)}</span>"
    exact = f'<td class="whole">{escape(row.exact)}</td>'
    return f'<tr><td class="name">{name}</td><td class="n">{rays}</td>{exact}{cells}</tr>'


def _outcome(outcome: Outcome) -> str:
    kind = {"ok": "ok", "fails": "fails", "n.a.": "none"}[outcome.verdict]
    return f'<td class="{kind}">{escape(outcome.text)}</td>'


def _findings(found: Iterable[Finding]) -> str:
    rows = []
    for finding in found:
        kind = {"ok": "ok", "fails": "fails", "n.a.": "none"}[finding.verdict]
        word = {"ok": "holds", "fails": "fails", "n.a.": "n.a."}[finding.verdict]
        rows.append(
            f"<tr><td><b>{escape(finding.claim[:1].upper() + finding.claim[1:])}</b></td>"
            f'<td class="{kind}">{word}</td><td>{escape(finding.evidence)}</td></tr>'
        )
    return _table("<tr><th>expectation</th><th></th><th>on this scene</th></tr>", rows)


def _orders(found: Iterable[Line]) -> str:
    classes = "".join(f'<th class="c first" colspan="4">{cls}</th>' for cls in CLASSES)
    columns = '<th class="n first">τ</th><th class="n">ρ</th><th>LiDARs</th><th>cameras</th>' * len(CLASSES)
    head = f"<tr><th></th>{classes}</tr><tr><th>setting</th>{columns}</tr>"
    rows = []
    for number, line in enumerate(found):
        kind = ' class="default"' if number == 0 else ""
        cells = "".join(_order_cells(cell) for cell in line.cells)
        rows.append(f"<tr{kind}><td>{escape(line.setting)}</td>{cells}</tr>")
    return _table(head, rows)


def _order_cells(cell: Cell) -> str:
    figures = (
        "–" if figure is None else f"{figure:.2f}".replace("-", "−") for figure in (cell.tau, cell.rho)
    )
    tau, rho = figures
    orders = ((cell.lidars, cell.lidars_as_default), (cell.cameras, cell.cameras_as_default))
    letters = "".join(
        f'<td class="letters{"" if same else " other"}">{" ".join(order) or "–"}</td>'
        for order, same in orders
    )
    return f'<td class="n first">{tau}</td><td class="n">{rho}</td>{letters}'
