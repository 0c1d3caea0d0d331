"""Numbers that no car and no camera has are refused by name; the limits themselves give rays."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.rig.model import Camera, Vehicle
from riglens.core.rig.pose_text import parse_pose
from riglens.core.rig.yaml.file import dumps, loads
from riglens.core.sensing.rays import sensor_rays
from riglens.core.vehicle.mesh_file import mesh_path, read_mesh
from tests.core.builders import rig_of

VEHICLE = "riglens: 1\nname: odd\nvehicle: {{{}}}\nsensors: []\n"
CAMERA = "riglens: 1\nname: odd\nsensors:\n  - {{name: C, kind: camera, position: [0, 0, 1], {}}}\n"
LENS = {"fx": "1000", "fy": "1000", "cx": "800", "cy": "450"}


def lens(**changes: str) -> str:
    return CAMERA.format(", ".join(f"{key}: {value}" for key, value in (LENS | changes).items()))


REFUSED = [
    (CAMERA.format("hfov_deg: 5.0e-324"), "hfov_deg must be at least 0.001 (got 5.0e-324)"),
    (CAMERA.format("hfov_deg: 179.99999999999997"), "hfov_deg must be at most 179.9"),
    (lens(fx="1.0e308"), "fx must be at most 10000000000 (got 1.0e+308)"),
    (lens(fy="1.0e-320"), "fy must be at least 0.0001 (got 1.0e-320)"),
    (lens(cx="1.0e308"), "cx must be at most 1000000 (got"),
    (lens(cy="-1.0e308"), "cy must be at least -1000000 (got"),
    (CAMERA.format("hfov_deg: 70, rpy_deg: [0, 0, 1.0e308]"), "rpy_deg[2] must be at most 1000000 (got"),
    (VEHICLE.format("length: 1.0e-4"), "vehicle.length must be at least 0.1 (got 0.0001)"),
    (VEHICLE.format("width: 5.0e-324"), "vehicle.width must be at least 0.1"),
    (VEHICLE.format("height: 0.09"), "vehicle.height must be at least 0.1 (got 0.09)"),
    (VEHICLE.format("mesh: {rpy_deg: [1.0e300, 0, 0]}"), "vehicle.mesh.rpy_deg[0] must be at most 1000000"),
    ('riglens: 1\nname: "half \\ud800"\nsensors: []\n', "text must consist of whole characters"),
]


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_a_number_out_of_the_limits_is_refused_by_name(text: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        loads(text, "odd.yaml")
    assert str(error.value).startswith("odd.yaml:") and message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("fields", "resolution"),
    [
        ("hfov_deg: 70", (1600, 900)),
        ("hfov_deg: 70, cast: [352, 128]", (352, 128)),
        ("hfov_deg: 70, image: [3840, 2160]", (3840, 2160)),
        ("hfov_deg: 70, image: [20000, 20000]", (2857, 2857)),
        (f"{', '.join(f'{key}: {value}' for key, value in LENS.items())}, image: [4100, 3001], "
         "distortion: {model: kannala_brandt}", (2050, 1500)),
    ],
)  # fmt: skip
def test_a_camera_casts_its_pixels_or_as_many_as_memory_holds(
    fields: str, resolution: tuple[int, int]
) -> None:
    camera = loads(CAMERA.format(fields), "odd.yaml").rig.sensors[0]
    assert camera.resolution == resolution
    assert loads(dumps(rig_of(camera)), "odd.yaml").rig.sensors[0].cast == camera.cast


AT_THE_LIMIT = [
    {"hfov_deg": 0.001},
    {"hfov_deg": 179.9},
    *({"fx": f, "fy": f, "cx": 800.0, "cy": 450.0} for f in (1e-4, 1e10)),
    *({"fx": f, "fy": 1.0, "cx": c, "cy": -c} for f in (1e-4, 1e10) for c in (1e6, -1e6)),
    {"hfov_deg": 70.0, "rpy_deg": (1e6, -1e6, 1e6)},
]


@pytest.mark.parametrize("fields", AT_THE_LIMIT)
def test_rays_at_the_limits_are_directions_and_the_rig_is_kept(fields: dict[str, object]) -> None:
    camera = Camera(name="C", position=(0.0, 0.0, 1.0), cast=(8, 4), **fields)  # type: ignore[arg-type]
    directions = sensor_rays(camera).directions
    assert np.allclose(np.linalg.norm(directions, axis=-1), 1.0, rtol=1e-9)
    assert loads(dumps(rig_of(camera))).rig == rig_of(camera)


@pytest.mark.parametrize("image", [(1, 1), (20_000, 20_000)])
@pytest.mark.parametrize("hfov_deg", [0.001, 179.9])
def test_every_field_of_view_has_a_focal_length(image: tuple[int, int], hfov_deg: float) -> None:
    narrow = Camera(name="C", position=(0.0, 0.0, 1.0), image=image, cast=(1, 1), hfov_deg=hfov_deg)
    fx, fy, cx, cy = narrow.intrinsics_px()
    assert narrow.replace(hfov_deg=None, fx=fx, fy=fy, cx=cx, cy=cy).intrinsics_px() == (fx, fy, cx, cy)


def test_the_smallest_and_the_largest_vehicle_are_vehicles() -> None:
    assert Vehicle(length=0.1, width=0.1, height=0.1) != Vehicle(length=100.0, width=100.0, height=100.0)


@pytest.mark.parametrize("text", ["0 0 1 0 0 1e308", "0 0 1 0 0 1000001", "0 0 1e8 0 0 0"])
def test_a_pasted_pose_has_the_same_limits(text: str) -> None:
    with pytest.raises(InputError, match="must be finite"):
        parse_pose(text)


def test_a_home_folder_that_nobody_has_is_no_such_file(tmp_path: Path) -> None:
    path = mesh_path("~nosuchuser/x.glb", tmp_path)
    assert path == tmp_path / "~nosuchuser" / "x.glb"
    with pytest.raises(InputError, match=r"vehicle\.body: .*x\.glb: no such file"):
        read_mesh(path)
