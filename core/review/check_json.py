"""Verdicts on requirements as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import date
from typing import Any

from riglens.core.metric.scores import Body
from riglens.core.review.findings import Verdict
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.file import identity_of


def check_document(
    rig: Rig,
    body: Body,
    verdicts: Sequence[Verdict],
    sources: Mapping[str, Any] | None = None,
    day: date | None = None,
) -> dict[str, Any]:
    """Return every verdict, and whether all requirements are met; waivers count on a given day, and not without one.

    sources: what the verdicts depend on besides the rig."""
    return {
        "riglens": FORMAT_VERSION,
        "body": body,
        "rig": identity_of(rig),
        **(sources or {}),
        "passes": all(verdict.holds_on(day) for verdict in verdicts),
        "verdicts": [_verdict(verdict, day) for verdict in verdicts],
    }


def _verdict(verdict: Verdict, day: date | None) -> dict[str, Any]:
    one, finding = verdict.item.requirement, verdict.finding
    return {
        "id": verdict.item.id,
        "section": verdict.item.section,
        "name": one.label,
        "why": one.why,
        "text": verdict.text,
        "found": finding.value,
        "relation": one.relation,
        "limit": one.accepted,
        "unit": one.unit,
        "status": verdict.status,
        "passes": verdict.passes,
        "bounds": None if finding.bounds is None else list(finding.bounds),
        "details": list(finding.details),
        "waived": None
        if one.waived is None
        else {
            "reason": one.waived.reason,
            "until": one.waived.until.isoformat(),
            "counts": verdict.is_waived_on(day),
        },
    }
