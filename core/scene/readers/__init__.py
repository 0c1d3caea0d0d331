"""Read boxes: detect the format of a path and stream its boxes into the vehicle frame."""

from riglens.core.scene.readers.bundled import bundled_occluders, bundled_source
from riglens.core.scene.readers.classes import parse_class_map
from riglens.core.scene.readers.opening import Source, default_origin_m, open_boxes, together

__all__ = [
    "Source",
    "bundled_occluders",
    "bundled_source",
    "default_origin_m",
    "open_boxes",
    "parse_class_map",
    "together",
]
