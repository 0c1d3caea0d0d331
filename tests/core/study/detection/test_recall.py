"""Recall by points counts each object once, by its class, points and distance."""

from __future__ import annotations

import numpy as np

from riglens.core.detect.precision import Detections, Truth
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.detection.recall import Recall, recall

CAR, PEDESTRIAN = CLASSES.index("car"), CLASSES.index("pedestrian")


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
