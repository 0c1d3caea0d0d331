"""Redundancy as plain data: shares as fractions, entropies in nat."""

from __future__ import annotations

from typing import Any

from riglens.core.metric.entropy import nats
from riglens.core.review.redundancy import COVERED, Coverage, Failure, What, lost_of
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS

WHAT: tuple[What, ...] = ("sensor", "pair", "group")


def _tried(found: Coverage) -> tuple[What, ...]:
    """Return what fails; half-blocked sensors only where they were tried."""
    return (*WHAT, "half") if any(one.what == "half" for one in found.failures) else WHAT


def coverage_document(found: Coverage, unit: str) -> dict[str, Any]:
    """Return a coverage by class; `unit` is that of `total`: nat or objects."""
    return {
        "unit": unit,
        "sectors": list(SECTORS),
        "classes": {name: _class_document(found, cls, unit) for cls, name in enumerate(CLASSES)},
        "failures": [_failure_document(found, failure) for failure in found.failures],
    }


def _class_document(found: Coverage, cls: int, unit: str) -> dict[str, Any]:
    total = int(found.total[:, cls].sum())
    covered = found.covered[:, :, cls]
    return {
        "total": nats(total) if unit == "nat" else total,
        "covered": {name: share(int(covered[:, k].sum()), total) for k, name in enumerate(COVERED)},
        "covered_by_sector": {
            name: [share(int(covered[s, k]), int(found.total[s, cls])) for s in range(len(SECTORS))]
            for k, name in enumerate(COVERED)
        },
        "worst": {what: _worst(found, what, cls, None) for what in _tried(found)},
        "worst_by_sector": {
            what: [_worst(found, what, cls, s) for s in range(len(SECTORS))] for what in _tried(found)
        },
    }


def _worst(found: Coverage, what: What, cls: int, sector: int | None) -> dict[str, Any] | None:
    failure = found.worst(what, cls, sector)
    if failure is None:
        return None
    return {"name": failure.name, "lost": lost_share(found, failure, cls, sector)}


def _failure_document(found: Coverage, failure: Failure) -> dict[str, Any]:
    return {
        "what": failure.what,
        "name": failure.name,
        "sensors": list(failure.members),
        "lost": {name: lost_share(found, failure, cls) for cls, name in enumerate(CLASSES)},
        "lost_by_sector": {
            name: [lost_share(found, failure, cls, s) for s in range(len(SECTORS))]
            for cls, name in enumerate(CLASSES)
        },
    }


def lost_share(found: Coverage, failure: Failure, cls: int, sector: int | None = None) -> float:
    """Return the loss by a failure as a share of the total of a class, everywhere or in one sector; less is better."""
    total = found.total[:, cls].sum() if sector is None else found.total[sector, cls]
    return share(lost_of(failure, cls, sector), int(total))


def share(part: int, total: int) -> float:
    """Return part / total, 0 for a total of 0."""
    return part / total if total else 0.0
