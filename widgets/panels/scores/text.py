"""Say what the figures beside each other mean: help, notes, and the line of what is found."""

from __future__ import annotations

from riglens.core.figures.figure import SE_FACTOR
from riglens.core.figures.predicted import of_100
from riglens.core.figures.values import FigureCells
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.evidence import EVIDENCE

SIGN_NOTE = (
    "<b>S-MS = λ · S-MIG(cameras) + S-MIG(LiDARs)</b>, in nat, with S-MIG = −(entropy of the "
    "voxels that the sensors reach), as the paper writes it.<br>So S-MS <b>falls</b> as "
    "coverage grows: without sensors it is 0. The paper argues that S-MS grows "
    "with coverage; its formula does the opposite. Read S-MS together with "
    "<b>seen</b>, the share of the scene's uncertainty that any sensor covers, which grows "
    "with coverage.<br>The order of rigs by S-MS depends on voxels and ray lattices: "
    "do not trust small differences."
)
SCORE_FIGURES = (
    (
        "Predicted AP",
        "is the average precision, in %, that a small detector would reach with these LiDARs and "
        "cameras in this traffic. Compare rigs by it, do not quote it: it does not predict your "
        "stack, and is grey for rigs unlike those of the study.",
    ),
    (
        "At least 5 points",
        "is the share of objects with 5 LiDAR points or more, with occlusion by traffic and a solid "
        "car's body. It ignores cameras.",
    ),
    (
        "Seen by cameras",
        "is the mean share of an object's silhouette that the picture which shows most of it shows. "
        "What lies outside the picture, behind traffic or behind the car is lost; the number of "
        "pixels does not count.",
    ),
    (
        "Missed",
        "is the share of objects that no sensor detects: too few LiDAR points, less than half of it "
        "in any picture, no radar or ultrasonic return. Less is better.",
    ),
    (
        "S-MS",
        "is the paper's score, for comparison with the paper. It decreases as coverage grows: do "
        "not read it as a grade. The order in which it ranks rigs depends on voxels and rays.",
    ),
)
"""The question each figure answers and its limits; README and docs/metric.md say the same."""
FIGURES_TITLE = "Four figures, four questions, and the paper's score"
FIGURES_HELP = "".join(f"<p><b>{name}</b> {said}</p>" for name, said in SCORE_FIGURES)
FIGURES_HELP += f"<p><b>Against a detector</b> {' '.join(EVIDENCE.values())}</p>"
NOT_COUNTED_NOTE = "Counting objects"
FOUND_NOTE = (
    "How many of 100 objects the detector of the second detection study would find with the points of the LiDARs, "
    "± two standard errors. It does not predict your stack; cameras are ignored. Grey outside its domain."
)


def found_text(found: FigureCells) -> str:
    """Say how many of 100 objects of each class are found, with two standard errors, and why the rig is outside the
    domain of that figure; empty where no calibration says so."""
    known = {name: value for name in CLASSES if (value := found.at(name)[0]).exists}
    said = of_100({name: (one.value, SE_FACTOR * one.se) for name, one in known.items()}, found.region)
    return f"{said} (outside the domain: {found.outside})" if said and found.outside else said
