"""The study of detection in files: tables as CSV, all of it as JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict, fields
from typing import Any

from riglens.core.rig.yaml.file import rig_sha256
from riglens.core.study.detection.protocol import WORDING
from riglens.core.study.detection.recall import Recall, Tally
from riglens.core.study.detection.result import Result
from riglens.core.study.detection.statistics import COLUMNS, Estimate
from riglens.core.study.detection.surrogates import SURROGATES

Line = dict[str, object]
_DIGITS = 4


def rig_lines(result: Result) -> Iterator[Line]:
    """Yield a line per rig and class: precision with interval, over all and over hit objects, then the surrogates."""
    for place, entrant in enumerate(result.study.compared):
        for column in COLUMNS:
            line: Line = {"rig": entrant.name, "rays": entrant.rays, "class": column}
            line |= _columns("ap", result.every.estimate(place, column))
            line |= _columns("ap_hit", result.hit.estimate(place, column))
            yield line | {name: _short(result.surrogates.of(name, column)[place]) for name in SURROGATES}


def seed_lines(result: Result) -> Iterator[Line]:
    """Yield a line per rig and seed: precision of each class over all objects."""
    for place, entrant in enumerate(result.study.compared):
        for seed in range(result.every.seeds):
            found = result.every.by_seed[place, seed]
            values = {column: _short(value) for column, value in zip(COLUMNS, found, strict=True)}
            yield {"rig": entrant.name, "seed": seed + 1} | values


def rank_lines(result: Result) -> Iterator[Line]:
    """Yield a line per group of rigs, class, surrogate and statistic."""
    for one in result.ranks:
        line: Line = {"among": one.among, "rigs": one.rigs, "class": one.column, "surrogate": one.surrogate}
        found = one.found
        line |= {"statistic": one.kind, "value": "", "low": "", "high": "", "p": "", "p_is_exact": ""}
        if found is not None:
            line |= {"value": _short(found.value), "low": _short(found.low), "high": _short(found.high)}
            line |= {"p": _short(found.p, 6), "p_is_exact": found.exact}
        yield line


def pair_lines(result: Result) -> Iterator[Line]:
    """Yield one line per pair of rigs and class: difference with interval, and verdict."""
    names = result.every.rigs
    for one in range(len(names)):
        for other in range(one + 1, len(names)):
            for column in COLUMNS:
                line: Line = {"rig": names[one], "other": names[other], "class": column}
                line |= _columns("difference", result.every.difference(one, other, column))
                yield line | {"verdict": result.every.verdict(one, other, column)}


def order_lines(result: Result) -> Iterator[Line]:
    """Yield a line per surrogate, class and distance of rigs: resolved pairs, and the number ordered the same way."""
    for one in result.orders:
        line: Line = {"surrogate": one.surrogate, "class": one.column, "apart": one.apart}
        yield line | {"pairs": one.pairs, "right": one.right}


RECALL_COLUMNS = ("class", "unit", "from", "to", "ring", "objects", "found", "recall")


TALLY_COLUMNS = tuple(one.name for one in fields(Tally))


def recall_lines(recalls: Iterable[Recall]) -> Iterator[Line]:
    """Yield a line per class, ring of distance (m) and number of points: objects, found ones, and their share."""
    for one in recalls:
        ring = "all" if one.ring_m is None else "{:g}-{:g}".format(*one.ring_m)
        most = "" if one.most is None else one.most
        line: Line = {"class": one.cls, "unit": "points", "from": one.least, "to": most, "ring": ring}
        yield line | {"objects": one.objects, "found": one.found, "recall": _short(one.found / one.objects)}


def as_json(result: Result) -> dict[str, Any]:
    """Return the whole result as `riglens study detection --json` writes it."""
    study, split = result.study, result.study.split
    return {
        "riglens": 1,
        "wording": WORDING,
        "protocol": study.protocol.as_dict(),
        "seeds": result.every.seeds,
        "machine": asdict(study.machine),
        "data": {
            "source": study.traffic.data.source,
            "sha256": study.traffic.data.sha256,
            "test_frames": len(split.test),
            "test_sequences": list(split.sequences),
        },
        "rigs": [_rig(result, place) for place in range(len(study.compared))],
        "ranks": list(rank_lines(result)),
        "pairs": list(pair_lines(result)),
        "orders": list(order_lines(result)),
        "predicted_missed": {column: _short(value) for column, value in result.missed.items()},
    }


def _rig(result: Result, place: int) -> dict[str, Any]:
    entrant = result.study.compared[place]
    by_seed = {
        column: [_short(value) for value in result.every.by_seed[place, :, number]]
        for number, column in enumerate(COLUMNS)
    }
    return {
        "name": entrant.name,
        "sha256": rig_sha256(entrant.rig),
        "rays": entrant.rays,
        "ap": {column: _columns("value", result.every.estimate(place, column)) for column in COLUMNS},
        "ap_by_seed": by_seed,
        "ap_hit": {column: _columns("value", result.hit.estimate(place, column)) for column in COLUMNS},
        "surrogates": {
            name: {column: _short(result.surrogates.of(name, column)[place]) for column in COLUMNS}
            for name in SURROGATES
        },
    }


def _columns(name: str, found: Estimate) -> Line:
    return {name: _short(found.value), f"{name}_low": _short(found.low), f"{name}_high": _short(found.high)}


def _short(value: float, digits: int = _DIGITS) -> float | str:
    """Return a figure rounded for tables; empty where there is none."""
    return round(float(value), digits) if math.isfinite(value) else ""
