"""Recall by points counts each object once, by its class, points and distance."""

from __future__ import annotations

import numpy as np

from riglens.core.detect.precision import Detections, Truth
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.detection.recall import MOST_POINTS, Recall, Tally, recall, tallies

CAR, PEDESTRIAN = CLASSES.index("car"), CLASSES.index("pedestrian")


TRUTH = Truth(
    frame=np.array([0, 0, 1, 1, 1]),
    cls=np.array([CAR, CAR, CAR, CAR, PEDESTRIAN], np.uint8),
    centre_m=np.array([[5.0, 0.0], [0.0, 9.0], [29.0, 19.0], [-29.0, 0.0], [5.0, 5.0]]),
    points=np.array([4, 4, 900, 900, 0]),
)
"""The third is farther than 30 m."""


def test_tallies_are_by_rig_and_by_sequence_of_near_objects() -> None:
    found = Detections(
        frame=np.array([0, 1, 1]),
        cls=np.array([CAR, CAR, CAR], np.uint8),
        centre_m=np.array([[5.5, 0.0], [-29.0, 1.0], [29.0, 19.0]]),
        score=np.array([0.9, 0.31, 0.9]),
    )
    nothing = found.where(found.score > 1.0)
    judged = [("one", TRUTH, found), ("other", TRUTH, nothing)]
    assert list(tallies(judged, ("early", "late"), np.array([0, 1]))) == [
        Tally("rig", "one", "car", 4, 2, 1),
        Tally("rig", "one", "car", MOST_POINTS, 1, 1),
        Tally("rig", "one", "pedestrian", 0, 1, 0),
        Tally("rig", "other", "car", 4, 2, 0),
        Tally("rig", "other", "car", MOST_POINTS, 1, 0),
        Tally("rig", "other", "pedestrian", 0, 1, 0),
        Tally("sequence", "early", "car", 4, 4, 1),
        Tally("sequence", "late", "car", MOST_POINTS, 2, 1),
        Tally("sequence", "late", "pedestrian", 0, 2, 0),
    ]


def test_found_objects_are_near_a_detection_of_their_class_with_a_sufficient_score() -> None:
    truth = Truth(
        frame=np.zeros(5, np.int64),
        cls=np.array([CAR, CAR, CAR, CAR, PEDESTRIAN], np.uint8),
        centre_m=np.array([[5.0, 0.0], [0.0, 9.0], [15.0, 0.0], [-25.0, 0.0], [5.0, 5.0]]),
        points=np.array([4, 3, 4, 60, 0]),
    )
    found = Detections(
        frame=np.array([0, 0, 0, 0, 1]),
        cls=np.array([CAR, CAR, CAR, PEDESTRIAN, CAR], np.uint8),
        centre_m=np.array([[6.0, 0.0], [0.0, 11.5], [15.0, 0.0], [5.0, 5.0], [-25.0, 0.0]]),
        score=np.array([0.9, 0.9, 0.29, 0.3, 0.9]),  # near, 2.5 m off, too low, just enough, another frame
    )
    assert list(recall([(truth, found), (truth, found)])) == [
        Recall("car", 3, 4, None, 6, 2),
        Recall("car", 50, None, None, 2, 0),
        Recall("car", 3, 4, (0.0, 10.0), 4, 2),
        Recall("car", 3, 4, (10.0, 20.0), 2, 0),
        Recall("car", 50, None, (20.0, 30.0), 2, 0),
        Recall("pedestrian", 0, 0, None, 2, 2),
        Recall("pedestrian", 0, 0, (0.0, 10.0), 2, 2),
    ]
