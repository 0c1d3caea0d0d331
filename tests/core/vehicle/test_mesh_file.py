"""Mesh files of car bodies: the formats that are read, what is refused, and that nothing outside is touched."""

import base64
import json
import os
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from riglens.core.errors import InputError
from riglens.core.rig.model import MeshPlacement, Vehicle
from riglens.core.vehicle.mesh import (
    BodyMesh,
    fitted_scale,
    is_car_size,
    mesh_size_m,
    unit_scales,
)
from riglens.core.vehicle.mesh_file import mesh_path, read_mesh
from riglens.core.vehicle.mesh_parse import FolderResolver, parse_mesh
from riglens.core.vehicle.mesh_structure import MAX_GROUPS, MAX_LEVELS, MAX_NODES

CORNERS = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 3]], dtype=np.float32)
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.uint16)
OBJ = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + "".join(
    "f " + " ".join(str(i + 1) for i in face) + "\n" for face in FACES
)
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    + "".join(f"{x} {y} {z} 200 30 40\n" for x, y, z in CORNERS)
    + "".join("3 " + " ".join(map(str, face)) + "\n" for face in FACES)
)


HUGE = [{"componentType": 5126, "count": 10**12, "type": "VEC3"}]


HALF = "half a character \ud800"


def gltf(uri: str | None = None, faces: np.ndarray = FACES, **extra: object) -> str:
    """A tetrahedron as glTF; its buffer is inside the file unless `uri` names another place."""
    content = CORNERS.tobytes() + faces.tobytes()
    inside = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1.0, 0.0, 0.0, 1.0]}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [0, 0, 0], "max": [2, 1, 3]},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "buffers": [{"byteLength": len(content), "uri": uri or inside}],
    }  # fmt: skip
    return json.dumps(tree | extra)


def stl() -> bytes:
    triangles = b"".join(
        struct.pack("<12fH", 0, 0, 0, *CORNERS[list(face)].ravel().tolist(), 0) for face in FACES
    )
    return bytes(80) + struct.pack("<I", len(FACES)) + triangles


def corners_of(arrays: dict[str, np.ndarray]) -> set[tuple[float, ...]]:
    return {tuple(point) for point in np.round(arrays["points"].astype(float), 5).tolist()}


def written(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize(("name", "content"), [("a.obj", OBJ), ("a.ply", PLY), ("a.STL", stl())])
def test_a_mesh_keeps_its_coordinates_and_triangles(tmp_path, name, content):
    arrays = parse_mesh(written(tmp_path, name, content))
    assert corners_of(arrays) == {tuple(point) for point in CORNERS.astype(float).tolist()}
    assert arrays["triangles"].shape == (4, 3)
    assert np.allclose(np.linalg.norm(arrays["normals"], axis=1), 1.0, atol=1e-5)


def test_a_gltf_is_stood_upright_with_its_front_ahead(tmp_path):
    arrays = parse_mesh(written(tmp_path, "a.gltf", gltf()))
    assert corners_of(arrays) == {(0, 0, 0), (0, 2, 0), (0, 0, 1), (3, 0, 0)}
    assert (arrays["colours"] == [255, 0, 0]).all()


def test_vertex_colours_are_read(tmp_path):
    arrays = parse_mesh(written(tmp_path, "a.ply", PLY))
    assert (arrays["colours"] == [200, 30, 40]).all()


def test_sharp_edges_stay_sharp(tmp_path):
    arrays = parse_mesh(written(tmp_path, "a.obj", OBJ))
    points, faces = arrays["points"][arrays["triangles"]], arrays["normals"][arrays["triangles"]]
    flat = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    assert np.allclose((faces * flat[:, None]).sum(axis=2), 1.0, atol=1e-5)


@pytest.mark.parametrize(
    "place", ["../secret.bin", "/etc/passwd", "..%2fsecret.bin", "http://example.org/a.bin"]
)
def test_a_buffer_outside_the_folder_is_refused_by_name(tmp_path, place):
    folder = tmp_path / "meshes"
    folder.mkdir()
    written(tmp_path, "secret.bin", CORNERS.tobytes() + FACES.tobytes())
    with pytest.raises(InputError, match="files in its own folder"):
        parse_mesh(written(folder, "a.gltf", gltf(place)))


def test_a_link_that_leads_out_of_the_folder_is_refused(tmp_path):
    folder = tmp_path / "meshes"
    folder.mkdir()
    (folder / "a.bin").symlink_to(written(tmp_path, "secret.bin", CORNERS.tobytes() + FACES.tobytes()))
    with pytest.raises(InputError, match=r"got 'a\.bin'"):
        parse_mesh(written(folder, "a.gltf", gltf("a.bin")))


def test_a_buffer_beside_the_file_is_read(tmp_path):
    written(tmp_path, "a.bin", CORNERS.tobytes() + FACES.tobytes())
    assert parse_mesh(written(tmp_path, "a.gltf", gltf("a.bin")))["triangles"].shape == (4, 3)


def test_materials_outside_the_folder_are_refused_and_missing_ones_are_done_without(tmp_path):
    folder = tmp_path / "meshes"
    folder.mkdir()
    with pytest.raises(InputError, match=r"got '\.\./paint\.mtl'"):
        parse_mesh(written(folder, "a.obj", "mtllib ../paint.mtl\n" + OBJ))
    assert len(parse_mesh(written(folder, "b.obj", "mtllib none.mtl\n" + OBJ))["triangles"]) == 4


def test_material_colours_of_an_obj_are_read(tmp_path):
    written(tmp_path, "paint.mtl", "newmtl red\nKd 1 0 0\n")
    text = OBJ.replace("f ", "usemtl red\nf ", 1)
    arrays = parse_mesh(written(tmp_path, "a.obj", "mtllib paint.mtl\n" + text))
    assert (arrays["colours"] == [255, 0, 0]).all()


def test_half_a_character_in_the_name_of_a_material_harms_nothing(tmp_path):
    mesh = read_mesh(written(tmp_path, "a.gltf", gltf(materials=[{"name": HALF}])))
    assert len(mesh.triangles) == 4


def test_textures_are_never_opened(tmp_path):
    resolver = FolderResolver(tmp_path)
    written(tmp_path, "skin.png", b"not a picture")
    with pytest.raises(FileNotFoundError, match="textures are not read"):
        resolver.get("skin.png")
    assert resolver.refused == ""


def nodes(*rows: dict[str, object]) -> bytes:
    return gltf(nodes=[{"mesh": 0}, *rows]).encode()


def levels(count: int) -> bytes:
    return gltf(
        nodes=[*({"mesh": 0, "children": [below]} for below in range(1, count)), {"mesh": 0}]
    ).encode()


def glb(tree: str) -> bytes:
    content = tree.encode() + b" " * (-len(tree) % 4)
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(content), len(content), 0x4E4F534A) + content


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.gltf", gltf(extensionsRequired=["KHR_draco_mesh_compression"]), "extension KHR_draco"),
        ("a.glb", glb(gltf(extensionsRequired=["EXT_meshopt_compression"])), "extension EXT_meshopt"),
        (
            "a.gltf",
            nodes({"rotation": [0, 0, 0, 0]}),
            "node 1: rotation must be a quaternion other than zero",
        ),
        ("a.gltf", nodes({"children": [2]}, {"children": [1]}), "below itself"),
        ("a.gltf", nodes({"children": [1]}), "below itself"),
        ("a.gltf", nodes({"children": [3]}, {"children": [3]}, {"mesh": 0}), "below two others"),
        ("a.gltf", nodes({"children": [9]}), r"children of nodes must be 0 to 1 \(got 9\)"),
        ("a.gltf", nodes(*[{}] * MAX_NODES), "more than 10,000 nodes"),
        ("a.gltf", levels(MAX_LEVELS + 1), "at most 100 levels deep"),
        ("a.gltf", gltf(meshes=[{"primitives": [{}] * (MAX_GROUPS + 1)}]), "more than 10,000 groups"),
        ("a.obj", OBJ + "usemtl a\n" * (MAX_GROUPS + 1), "more than 10,000 groups"),
    ],
)
def test_what_a_parser_would_not_read_or_not_end_is_refused_before(
    tmp_path, monkeypatch, name, content, said
):
    monkeypatch.setattr(trimesh, "load_scene", None)
    with pytest.raises(InputError, match=said):
        parse_mesh(written(tmp_path, name, content))


def test_nodes_may_lie_below_each_other_as_deep_as_the_limit(tmp_path):
    path = written(tmp_path, "a.gltf", levels(MAX_LEVELS))
    assert len(parse_mesh(path)["triangles"]) == 4 * MAX_LEVELS


def test_what_only_changes_the_looks_of_a_mesh_may_be_required(tmp_path):
    tree = gltf(extensionsRequired=["KHR_materials_unlit"], nodes=[{"children": [1]}, {"mesh": 0}])
    for name, content in (("a.gltf", tree), ("a.glb", glb(tree))):
        assert len(parse_mesh(written(tmp_path, name, content))["triangles"]) == 4


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.glb", b"glTF" + bytes(40), "not a readable .glb file"),
        ("a.gltf", b"{", "not a readable .gltf file"),
        ("a.obj", b"v 1 2 3\n", "contains no triangles"),
        ("a.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite|no triangles"),
        ("a.ply", b"ply\nformat", "not a readable .ply file"),
        ("a.stl", b"", "readable|no triangles"),
        ("a.gltf", gltf(accessors=HUGE).encode(), "readable|memory"),
    ],
)  # fmt: skip
def test_damaged_files_give_one_line(tmp_path, name, content, said):
    with pytest.raises(InputError, match=said) as caught:
        parse_mesh(written(tmp_path, name, content))
    assert "\n" not in str(caught.value)


def damaged(index: int) -> np.ndarray:
    faces = FACES.copy()
    faces[2, 1] = index
    return faces


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.gltf", gltf(faces=damaged(9)), "triangle 3 of 4: vertex numbers must be 0 to 3 (got 9)"),
        ("a.ply", PLY.replace("3 1 2 3", "3 1 9 3"), "triangle 3 of 4: vertex numbers must be 0 to 3 (got 9)"),
        ("a.ply", PLY.replace("3 1 2 3", "3 1 -1 3"), "triangle 3 of 4: vertex numbers must be 0 to 3 (got -1)"),
        ("a.obj", OBJ + "f 1 2 99\n", "not a readable .obj file (IndexError: index 98 is out of bounds"),
        ("a.obj", OBJ + "f a b c\n", "not a readable .obj file (ValueError: "),
        ("a.gltf", gltf("nowhere.bin"), "not a readable .gltf file (FileNotFoundError: nowhere.bin)"),
    ],
)  # fmt: skip
def test_a_damaged_mesh_says_why(tmp_path, name, content, said):
    with pytest.raises(InputError) as caught:
        parse_mesh(written(tmp_path, name, content))
    line = str(caught.value)
    assert said in line and line.isprintable() and len(line) < 250


def test_a_parser_that_crashes_is_told_with_its_signal(tmp_path, monkeypatch):
    crash = [sys.executable, "-c", "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"]
    real = subprocess.Popen
    monkeypatch.setattr(subprocess, "Popen", lambda command, **how: real(crash, **how))
    with pytest.raises(InputError, match=r"cannot be read: the reading process ended with signal 9"):
        read_mesh(written(tmp_path, "a.obj", OBJ))


LIMITS = """
import resource, sys
from riglens.core.limited_process import serve

limits = resource.getrlimit(resource.RLIMIT_AS)
assert limits == (resource.RLIM_INFINITY,) * 2, "the tests run in a limit of their own"
{before}
sys.exit(serve(lambda: repr(resource.getrlimit(resource.RLIMIT_AS)).encode(), 4 << 30))
"""
REFUSED = "def refuse(*_):\n    raise ValueError('current limit exceeds maximum limit')\nresource.setrlimit = refuse"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")
@pytest.mark.parametrize(
    ("before", "found"),
    [
        ("", (4 << 30, 4 << 30)),
        ("resource.setrlimit(resource.RLIMIT_AS, (2 << 30, -1))", (2 << 30, 2 << 30)),
        ("resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))", (3 << 30, 3 << 30)),
        (REFUSED, (-1, -1)),
    ],
)
def test_memory_is_limited_to_the_lowest_of_the_limits(before, found):
    done = subprocess.run(
        [sys.executable, "-c", LIMITS.format(before=before)], capture_output=True, encoding="utf-8"
    )
    assert (done.stdout, done.stderr) == (repr(found), "")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_no_mesh(tmp_path):
    os.mkfifo(tmp_path / "a.glb")
    with pytest.raises(InputError, match=r"a\.glb: cannot be read to its end"):
        read_mesh(tmp_path / "a.glb")


def test_more_triangles_than_can_be_drawn_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("riglens.core.vehicle.mesh_parse.MAX_TRIANGLES", len(FACES))
    assert len(parse_mesh(written(tmp_path, "a.obj", OBJ))["triangles"]) == len(FACES)
    monkeypatch.setattr("riglens.core.vehicle.mesh_parse.MAX_TRIANGLES", len(FACES) - 1)
    with pytest.raises(InputError, match="more than 3 triangles; simplify"):
        parse_mesh(written(tmp_path, "a.obj", OBJ))


def test_reading_happens_elsewhere_and_gives_the_arrays_back(tmp_path):
    asked = []
    mesh = read_mesh(written(tmp_path, "a.ply", PLY), lambda: asked.append(1))
    assert mesh.points.dtype == np.float32 and mesh.triangles.shape == (4, 3) and mesh.colours is not None
    half = gltf(nodes=[{"mesh": 0, "name": HALF}])
    for name, content, said in (
        ("bad.glb", b"glTF" + bytes(40), "not a readable .glb file (NotImplementedError: "),
        ("a.gltf", half, "not a readable .gltf file (UnicodeEncodeError: "),
    ):
        path = written(tmp_path, name, content)
        with pytest.raises(InputError) as caught:
            read_mesh(path)
        line = str(caught.value)
        assert line.startswith(f"vehicle.body: {path}: {said}") and line.isprintable() and len(line) < 400


def test_a_reading_that_nobody_wants_any_more_stops(tmp_path):
    class UnwantedError(Exception):
        pass

    def unwanted() -> None:
        raise UnwantedError

    with pytest.raises(UnwantedError):
        read_mesh(written(tmp_path, "a.obj", OBJ), unwanted)


def test_missing_files_other_kinds_and_too_large_ones_are_refused(tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"vehicle\.body: .*none\.glb: no such file"):
        read_mesh(tmp_path / "none.glb")
    with pytest.raises(InputError, match=r"vehicle\.body must be sedan, suv, van, truck or .*got 'car\.exe'"):
        read_mesh(written(tmp_path, "car.exe", b"MZ"))
    monkeypatch.setattr("riglens.core.vehicle.mesh_file.MAX_BYTES", 10)
    with pytest.raises(InputError, match="larger than"):
        read_mesh(written(tmp_path, "a.obj", OBJ))


def test_the_path_of_a_body_is_seen_from_the_rig_file(tmp_path):
    assert mesh_path("meshes/car.glb", tmp_path) == tmp_path / "meshes" / "car.glb"
    assert mesh_path(str(tmp_path / "car.glb"), Path("elsewhere")) == tmp_path / "car.glb"
    assert mesh_path("car.glb", None) == Path("car.glb")


def test_a_placed_mesh_is_scaled_then_turned_then_moved():
    mesh = BodyMesh(CORNERS, np.tile(np.array([[0, 0, 1]], np.float32), (4, 1)), FACES.astype(np.int32))
    placed = mesh.placed(MeshPlacement(scale=0.5, rpy_deg=(0.0, 0.0, 90.0), offset=(1.0, 2.0, 3.0)))
    assert np.allclose(placed.points[1], [1.0, 3.0, 3.0], atol=1e-6)
    assert np.allclose(placed.normals[0], [0, 0, 1], atol=1e-6)


def test_a_coarse_mesh_has_the_same_extent_from_far_fewer_triangles():
    u, v = np.meshgrid(np.linspace(0, 1, 120), np.linspace(0, 1, 120), indexing="ij")
    points = np.stack([4 * u, 2 * v, np.zeros_like(u)], axis=-1).reshape(-1, 3).astype(np.float32)
    index = np.arange(120 * 120).reshape(120, 120)
    first = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:]], axis=-1).reshape(-1, 3)
    second = np.stack([index[:-1, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 3)
    triangles = np.concatenate([first, second]).astype(np.int32)
    mesh = BodyMesh(points, np.zeros_like(points), triangles)
    coarse = mesh.coarse(20)
    assert 50 < len(coarse.triangles) < len(triangles) / 10
    assert np.allclose(np.ptp(coarse.points, axis=0), [4.0, 2.0, 0.0], atol=0.25)
    assert coarse.triangles.max() < len(coarse.points)


def test_the_size_of_a_placed_mesh_says_its_unit_and_fits_a_length() -> None:
    mesh = BodyMesh(1000 * CORNERS, CORNERS, FACES.astype(np.int32))
    assert mesh_size_m(mesh, MeshPlacement(scale=0.001)) == pytest.approx((2.0, 1.0, 3.0))
    turned = MeshPlacement(scale=0.001, rpy_deg=(0.0, 0.0, 90.0))
    assert mesh_size_m(mesh, turned) == pytest.approx((1.0, 2.0, 3.0))
    giant = mesh_size_m(mesh, MeshPlacement())
    assert not is_car_size(giant) and is_car_size((2.0, 1.0, 3.0)) and not is_car_size((0.9, 0.5, 0.4))
    assert unit_scales(giant, MeshPlacement()) == {"millimetres": 0.001, "centimetres": 0.01}
    assert fitted_scale(mesh, Vehicle(length=4.0, mesh=turned)) == pytest.approx(0.004)
    flat = BodyMesh(0 * CORNERS, CORNERS, FACES.astype(np.int32))
    assert fitted_scale(flat, Vehicle()) is None
