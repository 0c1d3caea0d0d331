"""Choose the body mode of rigs whose mesh file may not have been read yet, or cannot be read."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from riglens.core.metric.scores import Body, MetricSettings
from riglens.core.rig.model import Rig
from riglens.core.targets.settings import TargetSettings

_Settings = TypeVar("_Settings", MetricSettings, TargetSettings)


def known_body(rig: Rig, said: Body | None = None) -> Body:
    """Return whether rays end at a rig's car: as `said` for all rigs, else as the rig says.

    They pass through a body whose mesh has not been read.
    """
    return "ignored" if rig.vehicle.lacks_mesh else said or rig.body


def with_known_body(settings: _Settings, rig: Rig) -> _Settings:
    """Return the settings for one rig: its body mode in place of that of all rigs."""
    return replace(settings, body=known_body(rig, settings.body))
