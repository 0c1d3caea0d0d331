"""What the heatmap can show: the modes by their keys, and what they are called."""

from __future__ import annotations

from typing import Literal

HeatMode = Literal["off", "probability", "entropy", "seen", "unseen", "sensors", "change"]
HEAT_TITLES: dict[HeatMode, str] = {
    "off": "Off",
    "probability": "POG probability",
    "entropy": "Entropy",
    "seen": "Seen entropy",
    "unseen": "Unseen entropy",
    "sensors": "Sensors that see it",
    "change": "Gained and lost",
}
