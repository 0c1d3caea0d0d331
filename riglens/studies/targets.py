"""`riglens study targets`: predicted against true points on the objects of a recording."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.formats.opening import open_rig
from riglens.core.monitor import Monitor
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.readers import parse_class_map
from riglens.core.shown_tables import Block, ShownTable, Styled, table
from riglens.core.shown_text import visible
from riglens.core.study.target_counts import (
    EXPECTED,
    FAR_RINGS_M,
    FEWEST,
    GOOD_RANK,
    GOOD_RATIO,
    ONE_DRAW,
    RINGS_M,
    SHARES,
    VARIANTS,
    Pairs,
    class_masks,
    predict,
)
from riglens.core.study.true_points import Recorder, rigs_by_sequence, true_points
from riglens.evaluation.loading import note_data
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.traffic import load_traffic as read_traffic
from riglens.studies.files import csv_text, require_folder
from riglens.studies.pictures import picture

NAMES = ("targets.csv", "targets-objects.csv", "targets.png")
COLOURS = {"car": "#1f5fa8", "bicycle": "#c2410c", "pedestrian": "#3f7d3a"}


def study(
    scene: SceneOptions,
    rig: str | None,
    rigs: Path | None,
    recorder: Recorder,
    threads: int | None,
    out: Path,
    monitor: Monitor,
) -> list[Block]:
    """Return how predictions agree with a recording; write the tables and a chart."""
    assert scene.boxes is not None
    if rig is None and rigs is None:
        raise InputError("is needed, or", "rig", "rigs")
    if rig is not None and rigs is not None:
        raise InputError("cannot be combined with", "rig", "rigs")
    require_folder(out, NAMES)
    placed = rigs_by_sequence(rigs, recorder) if rigs is not None else open_rig(str(rig)).rig
    traffic = read_traffic(scene, 60.0)
    true = true_points(scene.boxes, parse_class_map(scene.classes))
    if len(true) != len(traffic.row):
        raise InputError(
            f"{scene.boxes}: needs one point count per box (got {len(true)} for {len(traffic.row)})"
        )
    labels = traffic.data.labels
    _check_rigs(placed, labels.names if labels is not None else ("all",))
    note_data(traffic.data, monitor)  # what is refused is refused in one line
    pairs = predict(traffic, true, placed, threads)
    write_file(out / NAMES[0], csv_text(list(summary(pairs))))
    write_file(out / NAMES[1], csv_text(list(objects(pairs))))
    write_file(out / NAMES[2], chart(pairs))
    said: list[Block] = [share_table(pairs)]
    for number in (*range(len(pairs.sequences)), None) if len(pairs.sequences) > 1 else (None,):
        name = "all together" if number is None else visible(pairs.sequences[number])
        said += [Styled(name, "bold"), ratio_table(pairs, number)]
    said += [verdict(pairs, variant) for variant in list(VARIANTS)[-2:]]
    return [*said, f"{out}: {', '.join(NAMES)}"]


def _check_rigs(rigs: Mapping[str, Rig] | Rig, sequences: tuple[str, ...]) -> None:
    for name in sequences if not isinstance(rigs, Rig) else ():
        if name not in rigs:
            raise InputError(f"needs a rig for sequence '{visible(name)}' of the boxes", "rigs")


def summary(pairs: Pairs) -> Iterator[dict[str, object]]:
    """Rank correlation per class, and median ratio per class and ring: one line each, per sequence and variant."""
    for number in (*range(len(pairs.sequences)), None):
        sequence = "all" if number is None else pairs.sequences[number]
        for variant in VARIANTS:
            for name, mask in class_masks(pairs).items():
                chosen = mask & pairs.of_sequence(number)
                line = {"sequence": sequence, "variant": variant, "class": name, "from_m": 0, "to_m": 60}
                yield line | _figures(pairs, variant, chosen)
                cls = CLASSES.index(name) if name in CLASSES else None
                for ring in FAR_RINGS_M if cls is None else RINGS_M:
                    inside = chosen & pairs.ring(cls, ring)
                    yield line | {"from_m": ring[0], "to_m": ring[1]} | _figures(pairs, variant, inside)


def _figures(pairs: Pairs, variant: str, chosen: NDArray[np.bool_]) -> dict[str, object]:
    ratio, count = pairs.ratio(variant, chosen)
    rank = pairs.rank(variant, chosen)
    sums = pairs.sums(variant, chosen)
    line: dict[str, object] = {"spearman": rank, "median_ratio": ratio, "n": count, "sum_ratio": sums}
    for least in SHARES:
        both = pairs.shares(variant, chosen, least) or ("", "")
        line |= {f"share_{least}": both[0], f"true_share_{least}": both[1]}
    return line


def objects(pairs: Pairs) -> Iterator[dict[str, object]]:
    """Yield one line per object: true and predicted points."""
    for place in range(len(pairs.cls)):
        yield {
            "seq": pairs.sequences[pairs.sequence[place]],
            "frame": int(pairs.frame[place]),
            "cls": CLASSES[pairs.cls[place]],
            "distance_m": round(float(pairs.distance_m[place]), 3),
            "true": int(pairs.true[place]),
        } | {
            variant: float(points[place]) if variant == EXPECTED else int(points[place])
            for variant, points in pairs.predicted.items()
        }


def share_table(pairs: Pairs) -> ShownTable:
    """Return shares of objects with enough points, predicted and true: sequences and classes as rows."""
    titles = (title for least in SHARES for title in (f"≥ {least}, predicted", "true"))
    shown = table(f"Share of objects, {ONE_DRAW}", *titles)
    for number in (*range(len(pairs.sequences)), None) if len(pairs.sequences) > 1 else (None,):
        sequence = "all together" if number is None else visible(pairs.sequences[number])
        for name, mask in class_masks(pairs).items():
            chosen = mask & pairs.of_sequence(number)
            found = [pairs.shares(ONE_DRAW, chosen, least) or (math.nan,) * 2 for least in SHARES]
            cells = ("–" if math.isnan(value) else f"{100 * value:.0f} %" for both in found for value in both)
            shown.add_row(f"{sequence}, {name}, {int(chosen.sum()):,}", *cells)
        shown.add_section()
    return shown


def ratio_table(pairs: Pairs, number: int | None) -> ShownTable:
    """Tabulate the variants as rows, one section per class."""
    rings = (f"{low:g}-{high:g} m" for low, high in RINGS_M)
    shown = table("predicted / true points", "Spearman", *rings)
    for name, mask in class_masks(pairs).items():
        chosen = mask & pairs.of_sequence(number)
        shown.add_row(Styled(f"{name}, {int(chosen.sum()):,}", "bold"))
        for variant in VARIANTS:
            rank = pairs.rank(variant, chosen)
            cells = [_ratio(pairs, variant, chosen, name, ring) for ring in RINGS_M if name in CLASSES]
            shown.add_row(f"  {variant}", "–" if rank is None else f"{rank:.3f}", *cells)
        shown.add_section()
    return shown


def _ratio(
    pairs: Pairs, variant: str, chosen: NDArray[np.bool_], name: str, ring: tuple[float, float]
) -> str:
    ratio, count = pairs.ratio(variant, chosen & pairs.ring(CLASSES.index(name), ring))
    return f"– ({count})" if ratio is None else f"{ratio:.2f} ({count})"


def verdict(pairs: Pairs, variant: str) -> str:
    """Describe how much of the goal a prediction method reaches."""
    rank = pairs.rank(variant, pairs.of_sequence(None))
    good = total = 0
    for number in range(len(pairs.sequences)):
        for cls in range(len(CLASSES)):
            for ring in RINGS_M:
                ratio, count = pairs.ratio(variant, pairs.of_sequence(number) & pairs.ring(cls, ring))
                if ratio is not None and count >= FEWEST:
                    total += 1
                    good += GOOD_RATIO[0] <= ratio <= GOOD_RATIO[1]
    ranked = (
        f"{variant}: Spearman {'–' if rank is None else f'{rank:.3f}'} over all (wanted: {GOOD_RANK:g}); "
    )
    if not total:
        return ranked + f"no class has {FEWEST} objects or more in a ring, so no median ratio is judged."
    return ranked + (
        f"the median ratio lies in {GOOD_RATIO[0]:g} to {GOOD_RATIO[1]:g} in {good} of {total} classes and rings "
        f"with {FEWEST} objects or more."
    )


def chart(pairs: Pairs) -> bytes:
    """Return a PNG of predicted against true points, one panel per method of prediction."""
    figure = Figure(figsize=(17.0, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, variant in zip(figure.subplots(1, len(VARIANTS), sharey=True), VARIANTS, strict=True):
        for number, name in enumerate(CLASSES):
            mine = (pairs.cls == number) & ((pairs.true > 0) | (pairs.predicted[variant] > 0))
            axes.plot(
                pairs.true[mine] + 0.5, pairs.predicted[variant][mine] + 0.5, ".", ms=3.5, alpha=0.45,
                mew=0, color=COLOURS[name], label=name,
            )  # fmt: skip
        top = 2.0 * max(pairs.true.max(initial=1), pairs.predicted[variant].max(initial=1))
        axes.plot([0.5, top], [0.5, top], color="#222222", lw=0.8)
        axes.set(xscale="log", yscale="log", xlabel="true points + 0.5")
        axes.set_title(variant, fontsize=10)
        rank = pairs.rank(variant, pairs.of_sequence(None))
        axes.text(
            0.03, 0.95, "" if rank is None else f"Spearman {rank:.3f}", transform=axes.transAxes, va="top"
        )
    figure.axes[0].set_ylabel("predicted points + 0.5")
    figure.axes[-1].legend(loc="lower right", markerscale=3)
    return picture(figure, dpi=130)
