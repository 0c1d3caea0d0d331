"""The stability study: where methods break, and where the metric does; both parts as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from riglens.core.scene.boxes import CLASSES, Progress
from riglens.core.study.rankings import LETTERS, Ranking, agreement
from riglens.core.study.stability_cases import RayCase, ray_cases
from riglens.core.study.stability_checks import check_rows
from riglens.core.study.stability_edits import random_edits
from riglens.core.study.stability_methods import METHODS, Row, judged
from riglens.core.study.stability_metric import MetricStudy
from riglens.core.study.stability_text import setting_text

EDITS, QUICK_EDITS = 1000, 100
Job = Callable[[Progress], Row]


@dataclass(frozen=True)
class StabilityStudy:
    """Part 1, one row per case; part 2, the orders of the paper's rigs on one scene."""

    rows: tuple[Row, ...]
    metric: MetricStudy

    def methods_csv(self) -> str:
        """Part 1 as CSV: per method the verdict, what it said, and voxels found, missed and extra."""
        return _csv([_method_line(row) for row in self.rows])

    def metric_csv(self) -> str:
        """Part 2 as CSV, full precision: a line per setting and class; every resample on its own."""
        lines = [_metric_line("default", "", self.metric.reference, self.metric, cls) for cls in CLASSES]
        for variation in self.metric.variations:
            name = setting_text(variation)
            lines += [
                _metric_line(variation.axis, name, variation.ranking, self.metric, cls) for cls in CLASSES
            ]
        for number, drawn in enumerate(self.metric.resamples, 1):
            lines += [
                _metric_line("frames", f"resample {number}", drawn, self.metric, cls) for cls in CLASSES
            ]
        return _csv(lines)


def method_rows(
    quick: bool = False, edits: int = EDITS, threads: int | None = None, progress: Progress | None = None
) -> tuple[Row, ...]:
    """Run every case of part 1; `progress` gets the fraction done."""
    jobs = [*_jobs(quick, edits, threads)]
    rows = []
    for number, job in enumerate(jobs):

        def part(fraction: float, done: int = number) -> None:
            if progress is not None:
                progress((done + fraction) / len(jobs))

        rows.append(job(part))
        part(1.0)
    return tuple(rows)


def _jobs(quick: bool, edits: int, threads: int | None) -> Iterator[Job]:
    for case in ray_cases(quick):
        yield _judging(case, threads)
    for check in check_rows(threads):
        yield _checking(check)
    yield lambda progress: random_edits(edits, progress)


def _judging(case: RayCase, threads: int | None) -> Job:
    return lambda progress: judged(case, threads, progress)


def _checking(check: Callable[[], Row]) -> Job:
    return lambda _: check()


def _csv(lines: list[dict[str, object]]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, list(lines[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    return text.getvalue()


def _method_line(row: Row) -> dict[str, object]:
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
