"""Tolerances as plain data, as `riglens tolerance --json` writes them: shares as fractions, mm and degrees."""

from __future__ import annotations

from typing import Any

from riglens.core.plain import to_plain
from riglens.core.review.tolerance import ToleranceResult
from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.rig.yaml.file import rig_sha256

SPREAD = ("nominal", "median", "p05", "p95", "worst", "worst_draw")


def tolerance_document(found: ToleranceResult, body: str) -> dict[str, Any]:
    """The tolerance of a rig under one profile."""
    return {
        "riglens": FORMAT_VERSION,
        "body": body,
        "rig": {"name": found.rig.name, "sha256": rig_sha256(found.rig)},
        "profile": to_plain(found.profile),
        "draws": found.draws,
        "seed": found.seed,
        "figures": {name: to_plain(spread, *SPREAD) for name, spread in found.spreads.items()},
        "noise_floor": {name: to_plain(spread, *SPREAD) for name, spread in found.floor.items()},
        "sensitivities": to_plain(found.sensitivities),
    }
