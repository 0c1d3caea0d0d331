"""One row per object, in the order of the data: its box, and the points and pixels of each sensor on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import kind_named
from riglens.core.targets.counts import Counted
from riglens.core.targets.traffic import Traffic

if TYPE_CHECKING:
    from pyarrow import Table

_DIGITS = 9
"""Decimals of place, size and yaw, which went through an origin and a rotation."""
_EXACT = 2.0**52
"""Up to this size a double has a fraction."""


def object_table(counted: Counted) -> Table:
    """Return an Arrow table with a row per object that counts in the frames used, in the order of the data.

    `points_NAME` rays of a LiDAR that reach it first, `pixels_NAME` native pixels of a camera that show it; `points`
    and `cells` of all LiDARs together. Raise InputError when two columns would have the same name.
    """
    import pyarrow as pa  # takes its time

    traffic, objects = counted.traffic, counted.objects
    order = np.argsort(traffic.row[objects.box], kind="stable")
    columns = list(_places(traffic, objects.box[order]).items())
    counts = {name: ("points", found) for name, found in zip(objects.lidars, objects.points.T, strict=True)}
    counts |= {name: ("pixels", found) for name, found in zip(objects.cameras, objects.pixels.T, strict=True)}
    for kind_name, returns in objects.returns.items():
        kind = kind_named(kind_name)
        assert kind is not None
        counts |= {
            name: (kind.hits.label, found)
            for name, found in zip(returns.names, returns.counts.T, strict=True)
        }
    for name in (sensor.name for sensor in counted.rig.sensors if sensor.name in counts):
        label, found = counts[name]
        columns.append((f"{label}_{name}", pa.array(found[order])))
    columns += [("points", pa.array(objects.all_points[order])), ("cells", pa.array(objects.cells[order]))]
    names = [name for name, _ in columns]
    if twice := [name for name in names if names.count(name) > 1]:
        raise InputError(
            f"two columns of the object table would be called '{twice[0]}'; give the sensors other names"
        )
    return pa.table(dict(columns))


def _places(traffic: Traffic, box: NDArray[np.int64]) -> dict[str, Any]:
    """Return seq, frame, class and box of the boxes (k,); a frame without a name has its number."""
    import pyarrow as pa

    number = traffic.frame[traffic.frame_of_box[box]]
    labels, turn = traffic.data.labels, traffic.rotation[box]
    sequence = np.zeros(len(box), np.int64) if labels is None else labels.sequence[number]
    columns = {
        "seq": pa.array([""] if labels is None else labels.names, pa.string()).take(pa.array(sequence)),
        "frame": pa.array(number if labels is None else labels.frame[number]),
        "cls": pa.array(CLASSES).take(pa.array(traffic.cls[box])),
    }
    places = np.column_stack(
        [traffic.centre_m[box], traffic.size_m[box], np.arctan2(turn[:, 1, 0], turn[:, 0, 0])]
    )
    for name, values in zip(("x", "y", "z", "length", "width", "height", "yaw"), places.T, strict=True):
        columns[name] = pa.array(rounded(values))
    return columns


def rounded(values: NDArray[np.float64], digits: int = _DIGITS) -> NDArray[np.float64]:
    """Round to a number of decimals as Python's `round` does, to the last bit; numpy's own is off where ties are near.

    A whole number over a power of ten is the double next to that decimal, as `round` gives. Only which whole number
    is in doubt where the product, itself rounded, comes to lie near a tie: Python decides there.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = values * 10.0**digits
        whole = np.rint(scaled)
        from_tie = np.abs(np.abs(scaled - whole) - 0.5)
        is_clear = (from_tie > 2.0 * np.spacing(np.abs(scaled))) & (np.abs(scaled) < _EXACT)
    result = whole / 10.0**digits
    for place in np.flatnonzero(~is_clear).tolist():
        result[place] = round(float(values[place]), digits)
    return result
