"""State the results of the published detection study on the figures that rigs are judged by."""

from __future__ import annotations

PAGE = "study-detection.md"
EVIDENCE = {
    "on_target": (
        "On target ranked 30 rigs nearly as the mAP of a detector trained on simulated sweeps did: Spearman 0.99 "
        "[0.95, 1.00], with equal rays 0.96 [0.75, 1.00], and so did the share of objects with 5 points. It shares "
        "class shapes and range law with that simulation."
    ),
    "seen": (
        "Seen ranked them with Spearman 0.79 [0.53, 0.93], no better than the number of rays does; the 17 rigs of "
        "equal rays with 0.21 [−0.37, 0.69], where two families of rigs have opposite signs."
    ),
    "s_ms": (
        "S-MS fell where mAP rose, Spearman −0.73 [−0.91, −0.42]; with equal rays 0.11 [−0.48, 0.61], again with "
        "opposite signs."
    ),
}
"""By the name of the figure, one or two sentences with 95 % intervals; from docs/data/detection-ranks.csv."""
