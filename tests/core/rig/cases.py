"""Random valid rigs, and ways of writing them as YAML, for the tests of rig files."""

import math
from typing import Any

from hypothesis import strategies as st
from pydantic import ValidationError

from riglens.core.rig.library import default_library
from riglens.core.rig.model import (
    BrownConrady,
    Camera,
    KannalaBrandt,
    Lidar,
    LinearAngles,
    MeshPlacement,
    Rig,
    Vehicle,
)

NASTY = st.sampled_from([-0.0, 0.0, 1e-17, -1e-300, 5e-324, 0.1 + 0.2, 1 / 3, 1e7, 123456.789])
ANY_NAME = st.text(min_size=1, max_size=12) | st.sampled_from(
    ["no", "1.5", "~", "a: b", "# x", " x ", "é", "x\ny", "😀"]
)


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Doubles in [low, high], the nasty ones often."""
    return st.floats(low, high, allow_nan=False) | NASTY.filter(lambda value: low <= value <= high)


def angles(limit_deg: float) -> st.SearchStrategy[LinearAngles | tuple[float, ...]]:
    """Angles in [-limit, limit] degrees, as a list or evenly spaced."""
    listed = st.lists(numbers(-limit_deg, limit_deg), min_size=1, max_size=5).map(tuple)
    ends = st.tuples(numbers(-limit_deg, limit_deg), numbers(-limit_deg, limit_deg)).map(sorted)
    even = st.builds(lambda e, n: LinearAngles(from_=e[0], to=e[1], count=n), ends, st.integers(1, 1000))
    return listed | even


RANGES = st.just((0.0, math.inf)) | st.tuples(numbers(0, 10), numbers(11, 300) | st.just(math.inf))
POSITIONS = st.tuples(*[numbers(-1e7, 1e7)] * 3)
ANGLES3 = st.tuples(*[numbers(-1e6, 1e6)] * 3)


def common(names: st.SearchStrategy[str], kind: str) -> dict[str, st.SearchStrategy[object]]:
    """The fields that every sensor has."""
    models = [None, *(entry.name for entry in default_library().entries() if entry.kind == kind)]
    return {
        "name": names,
        "model": st.sampled_from(models),
        "position": POSITIONS,
        "rpy_deg": ANGLES3,
        "range_m": RANGES,
        "enabled": st.booleans(),
    }


def lidars(names: st.SearchStrategy[str]) -> st.SearchStrategy[Lidar]:
    """Any LiDAR."""
    plain = st.builds(
        Lidar, **common(names, "lidar"), elevations_deg=angles(90.0), azimuths_deg=angles(180.0)
    )
    return plain | st.builds(_with_offsets, plain, numbers(-360.0, 360.0))


def _with_offsets(lidar: Lidar, first_deg: float) -> Lidar:
    if lidar.beam_count > 30:
        return lidar
    offsets_deg = (first_deg, *(float(beam) / 7 for beam in range(1, lidar.beam_count)))
    return lidar.replace(azimuth_offsets_deg=offsets_deg)


def lenses() -> st.SearchStrategy[BrownConrady | KannalaBrandt]:
    """Any coefficients of lens distortion."""
    number = numbers(-1e9, 1e9)
    brown = {name: number for name in BrownConrady.model_fields if name != "model"}
    fisheye = {name: number for name in KannalaBrandt.model_fields if name != "model"}
    return st.builds(BrownConrady, **brown) | st.builds(KannalaBrandt, **fisheye)


def _with_rays(**fields: Any) -> Camera:
    """Return a camera; without distortion where that would leave no ray on the image, which is refused."""
    try:
        return Camera(**fields)
    except ValidationError:
        return Camera(**fields | {"distortion": None})


def cameras(names: st.SearchStrategy[str]) -> st.SearchStrategy[Camera]:
    """Any camera, its lens as a field of view or as a matrix."""
    size = {
        "image": st.tuples(*[st.integers(400, 20_000)] * 2),
        "cast": st.tuples(*[st.integers(1, 400)] * 2),
    }
    focal, centre = numbers(1e-4, 1e10), numbers(-1e6, 1e6)
    by_angle = st.builds(Camera, **common(names, "camera"), **size, hfov_deg=numbers(0.001, 179.9))
    by_matrix = st.builds(
        _with_rays,
        **common(names, "camera"),
        **size,
        fx=focal,
        fy=focal,
        cx=centre,
        cy=centre,
        hfov_deg=st.none(),
        distortion=st.none() | lenses(),
    )
    return by_angle | by_matrix


def rigs(names: st.SearchStrategy[str] = ANY_NAME, max_sensors: int = 4) -> st.SearchStrategy[Rig]:
    """Any valid rig whose sensors have names of that kind."""
    length = numbers(0.1, 100.0)
    placements = st.builds(MeshPlacement, scale=numbers(1e-6, 1e6), rpy_deg=ANGLES3, offset=POSITIONS)
    vehicles = st.builds(
        Vehicle,
        body=ANY_NAME,
        length=length,
        width=length,
        height=length,
        rear_axle_x=numbers(-1e7, 1e7),
        mesh=st.just(MeshPlacement()) | placements,
    )
    sensors = st.lists(
        lidars(names) | cameras(names), max_size=max_sensors, unique_by=lambda sensor: sensor.name
    ).map(tuple)
    return st.builds(Rig, name=ANY_NAME, vehicle=vehicles, sensors=sensors)
