"""Tolerances as plain data, as `riglens tolerance --json` writes them: shares as fractions, mm and degrees."""

from __future__ import annotations

from typing import Any

from riglens.core.review.tolerance import Spread, ToleranceResult
from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.rig.yaml.file import rig_sha256


def tolerance_document(found: ToleranceResult, body: str) -> dict[str, Any]:
    """The tolerance of a rig under one profile."""
    return {
        "riglens": FORMAT_VERSION,
        "body": body,
        "rig": {"name": found.rig.name, "sha256": rig_sha256(found.rig)},
        "profile": found.profile.model_dump(),
        "draws": found.draws,
        "seed": found.seed,
        "figures": {name: _spread(spread) for name, spread in found.spreads.items()},
        "noise_floor": {name: _spread(spread) for name, spread in found.floor.items()},
        "sensitivities": [
            {"sensor": one.sensor, "axis": one.axis, "limit": one.limit, "effect": dict(one.effect)}
            for one in found.sensitivities
        ],
    }


def _spread(spread: Spread) -> dict[str, Any]:
    return {
        "nominal": spread.nominal,
        "median": spread.median,
        "p05": spread.p05,
        "p95": spread.p95,
        "worst": spread.worst,
        "worst_draw": spread.worst_draw,
    }
