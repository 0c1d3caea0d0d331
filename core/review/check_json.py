"""Verdicts on requirements as plain data, as `riglens check --json` writes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from riglens.core.metric.scores import Body
from riglens.core.review.requirements import Verdict
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.file import rig_sha256


def check_document(rig: Rig, body: Body, verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Every verdict, and whether all requirements are met."""
    return {
        "riglens": FORMAT_VERSION,
        "body": body,
        "rig": {"name": rig.name, "sha256": rig_sha256(rig)},
        "passes": all(verdict.passes for verdict in verdicts),
        "verdicts": [
            {
                "section": verdict.section,
                "text": verdict.text,
                "found": verdict.found,
                "relation": verdict.relation,
                "limit": verdict.limit,
                "unit": verdict.unit,
                "passes": verdict.passes,
            }
            for verdict in verdicts
        ],
    }
