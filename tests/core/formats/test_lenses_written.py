"""Fields of view are those of the lens in every format, and what a format cannot hold is told with its size.

What is expected follows from the equidistant law r = f theta and from tangents, not from the product's lenses.
"""

import json
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from riglens.core.formats.lens_export import _farthest, extent, most_off_deg
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, LinearAngles, Rig
from riglens.core.sensors.camera import pixel_directions
from riglens.core.sensors.lens import radial_of
from tests.core.formats.cases import camera, lidar, read_files, report_on, rig_of, written
from tests.core.formats.test_reports import has
from tests.core.formats.test_round_trips import again

LEVEL = ((0.5, 0.25, 1.75), (0.0, 0.0, 0.0))
WIDE = {"fx": 210.0, "fy": 210.0, "cx": 400.0, "cy": 300.0, "distortion": KannalaBrandt()}
WIDE_DEG = math.degrees(800.0 / 210.0)
"""800 pixels at 210 pixels for each radian: 218.3 degrees, where a pinhole of that focal length has 124.6."""

MEDIUM = {"fx": 380.0, "fy": 380.0, "cx": 400.0, "cy": 300.0, "distortion": KannalaBrandt()}
MEDIUM_DEG = math.degrees(800.0 / 380.0)
"""120.6 degrees, where a pinhole of that focal length has 92.9."""

BENT = {"fx": 380.0, "fy": 380.0, "cx": 400.0, "cy": 300.0, "distortion": BrownConrady(k1=-0.2)}


def osi_fields_deg(rig: Rig) -> tuple[float, float]:
    (text,) = written("osi", rig).values()
    message = json.loads(text)["sensor_view_configuration"][0]
    (view,) = message[next(key for key in message if key.endswith("_sensor_view_configuration"))]
    keys = ("field_of_view_horizontal", "field_of_view_vertical")
    assert [message[key] for key in keys] == [view[key] for key in keys]
    return math.degrees(view[keys[0]]), math.degrees(view[keys[1]])


def urdf_camera(rig: Rig) -> ElementTree.Element:
    (text,) = written("urdf", rig).values()
    (sensor,) = ElementTree.fromstring(text).iter("sensor")
    return sensor


def text_of(element: ElementTree.Element, path: str) -> str:
    found = element.findtext(path)
    assert found is not None
    return found


@pytest.mark.parametrize(("lens", "wide_deg"), [(WIDE, WIDE_DEG), (MEDIUM, MEDIUM_DEG)])
def test_osi_and_urdf_have_the_field_of_view_of_a_fisheye(lens: dict[str, object], wide_deg: float) -> None:
    rig = rig_of(camera("eye", LEVEL, **lens))
    assert osi_fields_deg(rig) == pytest.approx((wide_deg, wide_deg * 600.0 / 800.0))
    found = math.degrees(float(text_of(urdf_camera(rig), "camera/horizontal_fov")))
    assert found == pytest.approx(wide_deg)


def test_carla_has_the_field_of_view_of_a_fisheye_as_far_as_a_pinhole_can() -> None:
    for name in ("carla", "carla-toml"):
        (back,) = again(name, rig_of(lidar("l", LEVEL), camera("eye", LEVEL, **MEDIUM))).sensors[-1:]
        assert isinstance(back, Camera) and back.hfov_deg == pytest.approx(MEDIUM_DEG)
        rig = rig_of(lidar("l", LEVEL), camera("eye", LEVEL, **WIDE))
        (back,) = again(name, rig).sensors[-1:]
        assert isinstance(back, Camera) and back.hfov_deg == 179.0
        assert has(report_on(name, rig), "approximated", "field of view 218.3 x 163.7 deg", "179.0 x", "eye")
        assert has(report_on(name, rig), "ignored", "lens distortion", "deg off", "eye")


def test_the_field_of_view_of_a_bent_pinhole_is_found_by_inverting_its_law() -> None:
    """The edge of the image lies where r (1 - 0.2 r^2) = 400 / 380 has its smaller root."""
    roots = np.roots([-0.2, 0.0, 1.0, -300.0 / 380.0])
    up = min(root.real for root in roots if abs(root.imag) < 1e-12 and root.real > 0.0)
    found = extent(camera("bent", LEVEL, **BENT))
    assert found.up_deg == pytest.approx(math.degrees(math.atan(up)))
    assert found.down_deg == pytest.approx(found.up_deg)


def test_a_lens_that_ends_inside_its_image_is_as_wide_as_what_it_sees() -> None:
    """r (1 - 0.2 r^2) grows up to r = sqrt(5 / 3), where it is 0.861: less than the 1.053 of the image's edge."""
    found = extent(camera("bent", LEVEL, **BENT))
    assert found.left_deg == pytest.approx(math.degrees(math.atan(math.sqrt(5.0 / 3.0))), abs=1e-3)
    wide_deg, high_deg = osi_fields_deg(rig_of(camera("bent", LEVEL, **BENT)))
    assert wide_deg == pytest.approx(2.0 * found.left_deg) and high_deg == pytest.approx(2.0 * found.up_deg)


def test_urdf_has_a_pinhole_with_the_edges_of_a_bent_lens() -> None:
    lens = {**BENT, "fx": 600.0, "fy": 610.0, "cx": 380.0, "cy": 310.0}
    own = camera("bent", LEVEL, **{**lens, "distortion": BrownConrady(k1=-0.2, k4=0.01)})
    (back,) = again("urdf", rig_of(own)).sensors
    assert isinstance(back, Camera) and back.distortion is None
    assert extent(back) == pytest.approx(extent(own))


def test_urdf_brings_back_a_bent_lens_bit_for_bit() -> None:
    lens = {**BENT, "fx": 600.0, "fy": 610.0, "cx": 380.0, "cy": 310.0}
    bend = BrownConrady(k1=-0.2, k2=0.03, p1=0.001, p2=-0.002, k3=0.01)
    own = camera("bent", LEVEL, **{**lens, "distortion": bend})
    (back,) = again("urdf", rig_of(own)).sensors
    assert isinstance(back, Camera) and back.distortion == bend
    assert back.intrinsics_px() == own.intrinsics_px()


def test_urdf_brings_back_an_equidistant_fisheye() -> None:
    rig = rig_of(camera("eye", LEVEL, **WIDE))
    sensor = urdf_camera(rig)
    assert sensor.get("type") == "wideanglecamera" and text_of(sensor, "camera/lens/type") == "equidistant"
    (back,) = again("urdf", rig).sensors
    assert isinstance(back, Camera) and back.distortion == KannalaBrandt()
    assert back.intrinsics_px() == pytest.approx((210.0, 210.0, 400.0, 300.0))


@pytest.mark.parametrize(
    "lens", [WIDE, {**WIDE, "fx": 215.0, "distortion": KannalaBrandt(k1=0.05, k2=-0.01)}]
)
def test_driveworks_brings_back_a_fisheye_bit_for_bit(lens: dict[str, object]) -> None:
    own = camera("eye", LEVEL, **lens)
    (back,) = again("driveworks", rig_of(own)).sensors
    assert isinstance(back, Camera)
    assert back.intrinsics_px() == pytest.approx(own.intrinsics_px(), rel=1e-15)
    assert most_off_deg(own, back) < 1e-6
    assert not has(report_on("driveworks", rig_of(own)), "approximated", "eye")


def test_driveworks_brings_back_any_fisheye_within_the_error_that_it_tells() -> None:
    bend = KannalaBrandt(k1=0.05, k2=-0.02, k3=0.004, k4=-0.0005)
    own = camera("eye", LEVEL, **{**WIDE, "distortion": bend})
    report = report_on("driveworks", rig_of(own))
    assert has(report, "approximated", "nearest f-theta polynomial", "pixels off", "eye")
    (back,) = again("driveworks", rig_of(own)).sensors
    assert isinstance(back, Camera) and most_off_deg(own, back) < 0.5


def test_an_f_theta_lens_of_a_driveworks_file_goes_out_and_in_again() -> None:
    from tests.core.formats.cases import SMALL

    own = read_files(SMALL["driveworks"]).rig.sensor("camera:front")
    (back,) = again("driveworks", rig_of(own)).sensors
    assert isinstance(own, Camera) and isinstance(back, Camera)
    assert most_off_deg(own, back) < 0.005


def test_driveworks_keeps_the_radial_part_of_a_distortion_and_tells_the_rest() -> None:
    bend = BrownConrady(k1=-0.1, k2=0.02, p1=0.001)
    own = camera("c", LEVEL, **{**BENT, "distortion": bend})
    (back,) = again("driveworks", rig_of(own)).sensors
    assert isinstance(back, Camera) and back.distortion == BrownConrady(k1=-0.1, k2=0.02)
    assert has(report_on("driveworks", rig_of(own)), "ignored", "no p1", "deg off", "c")


def test_driveworks_has_the_nearest_polynomial_of_a_rational_lens() -> None:
    bend = BrownConrady(k1=0.1, k2=0.01, k4=0.2, k5=0.02)
    own = camera("c", LEVEL, **{**BENT, "distortion": bend})
    (back,) = again("driveworks", rig_of(own)).sensors
    assert isinstance(back, Camera) and most_off_deg(own, back) < 0.2
    assert has(report_on("driveworks", rig_of(own)), "ignored", "no k4 k5", "deg off", "c")


def test_a_rational_lens_that_ends_at_a_pole_is_written_without_a_warning() -> None:
    """At 30 degrees off the axis the image is infinitely far out, which divides by zero."""
    own = camera("c", LEVEL, **{**BENT, "distortion": BrownConrady(k1=5.0, k4=-3.0, p1=0.1)})
    assert has(report_on("driveworks", rig_of(own)), "ignored", "no p1 k4", "c")


def test_a_lens_is_fitted_up_to_the_corner_or_nearly_to_where_it_ends_before() -> None:
    radial = radial_of(BrownConrady(k1=-0.5))  # grows up to r = sqrt(2 / 3), which is at 0.544 of the plane
    for focal_px, farthest in ((2000.0, None), (500.0, 0.999 * math.sqrt(2.0 / 3.0))):
        found = _farthest(camera("c", LEVEL, **BENT | {"fx": focal_px, "fy": focal_px}), radial)
        r = np.array([found])
        assert found == pytest.approx(farthest or r[0])
        assert farthest or radial.value(r) == pytest.approx(500.0 / focal_px)


def test_the_error_of_a_lens_is_the_largest_angle_between_rays_of_one_pixel() -> None:
    own = camera("eye", LEVEL, **MEDIUM)
    pinhole = own.replace(distortion=None)
    corner = np.array([[0.0, 0.0]])
    one, other = (pixel_directions(lens, corner)[0] for lens in (own, pinhole))
    assert most_off_deg(own, pinhole) == pytest.approx(math.degrees(math.acos(one @ other)))


def test_what_an_import_of_a_linear_term_means() -> None:
    """linear-c stretches the image along u: DriveWorks, dwFThetaCameraConfig."""
    properties = {
        "Model": "ftheta",
        "width": "800",
        "height": "600",
        "cx": "400",
        "cy": "300",
        "polynomial": "0 210 0 2.1",
        "polynomial-type": "angle-to-pixeldistance",
        "linear-c": "1.5",
    }
    pose = {"roll-pitch-yaw": [0.0, 0.0, 0.0], "t": [0.0, 0.0, 0.0]}
    sensor = {"name": "a", "protocol": "camera.gmsl", "nominalSensor2Rig_FLU": pose, "properties": properties}
    imported = read_files({"rig.json": json.dumps({"rig": {"sensors": [sensor]}})}, "driveworks")
    (found,) = imported.rig.sensors
    assert isinstance(found, Camera) and found.intrinsics_px() == (315.0, 210.0, 400.0, 300.0)
    assert found.distortion == KannalaBrandt(k1=0.01)


@pytest.mark.parametrize(
    ("name", "pieces"),
    [
        ("osi", ("elevations -25 to 15 deg", "±25 deg", "10 deg off")),
        ("osi", ("azimuths 30 to 90 deg", "±90 deg", "120 deg off")),
        ("osi", ("smallest range 0.5 m",)),
        ("carla", ("azimuths 30 to 90 deg", "±30 deg", "60 deg off")),
        ("carla", ("smallest range 0.5 m",)),
        ("carla", ("azimuth offsets", "up to 2.50 deg off")),
        ("carla", ("uneven angles", "beams", "up to 10.00 deg off")),
        ("carla-toml", ("yaw", "heading 35.00 deg off")),
        ("carla-toml", ("azimuths 30 to 90 deg", "300 deg more")),
        ("urdf", ("uneven angles", "beams", "up to 10.00 deg off")),
        ("urdf", ("azimuth offsets", "up to 2.50 deg off")),
    ],
)
def test_heading_and_extent_that_a_lidar_loses_are_told_with_their_size(
    name: str, pieces: tuple[str, ...]
) -> None:
    """Beams at -25, -15 and 15 degrees: evenly spaced, the middle one would be at -5."""
    turned = (LEVEL[0], (0.0, 0.0, 35.0))
    top = lidar(
        "top",
        turned,
        elevations_deg=(-25.0, -15.0, 15.0),
        azimuths_deg=LinearAngles(from_=30.0, to=90.0, count=60),
        azimuth_offsets_deg=(0.0, -2.5, 1.0),
        range_m=(0.5, 90.0),
    )
    assert has(report_on(name, rig_of(top)), *pieces, "top")


@pytest.mark.parametrize("name", ["osi", "carla", "carla-toml", "urdf"])
def test_what_is_held_is_not_called_lost(name: str) -> None:
    even = {"elevations_deg": LinearAngles(from_=-9.0, to=9.0, count=4)}
    rig = rig_of(camera("c", LEVEL), lidar("l", LEVEL, **even))
    lines = [line for line in report_on(name, rig).lines() if " off" in line or "field of view 8" in line]
    assert not lines
    whole = LinearAngles(from_=-60.0, to=60.0, count=240)
    level = rig_of(lidar("l", LEVEL, azimuths_deg=whole, **even))
    assert not any(" off" in line for line in report_on(name, level).lines())
    if name == "osi":
        assert osi_fields_deg(level) == pytest.approx((120.0, 18.0))
