"""State the results of the published detection study on the figures that rigs are judged by; docs repeat them."""

from __future__ import annotations

PAGE = "study-detection.md"
EVIDENCE = {
    "on_target": (
        "On target ranked 30 rigs nearly as the mAP of a detector trained on simulated sweeps did: Spearman 0.95 "
        "[0.83, 1.00], with equal rays 0.97 [0.75, 1.00]. It shares class shapes and range law with that "
        "simulation, and was no better than seen where only road users with a LiDAR point counted."
    ),
    "seen": (
        "Seen ranked them with Spearman 0.79 [0.53, 0.93], but the 17 rigs of equal rays with 0.21 [−0.37, 0.69]: "
        "between equal budgets it said nothing."
    ),
    "s_ms": (
        "S-MS fell where mAP rose, Spearman −0.73 [−0.91, −0.42]; with equal rays 0.11 [−0.48, 0.61], nothing."
    ),
}
"""By the name of the figure, one or two sentences with 95 % intervals; from docs/data/detection-ranks.csv."""
