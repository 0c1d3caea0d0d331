"""`riglens library`: lists, shows and prints the sensor models; models of one's own by --library."""

import json

import pytest

OWN = """\
my-cam:
  kind: camera
  maker: Yard
  title: Camera of our own
  source: Calibrated in the yard in March
  image: [800, 600]
  fx: 400
  fy: 400
  cx: 400
  cy: 300
  distortion: {model: brown_conrady, k1: -0.1}
"""


def test_the_list_fits_100_columns_and_groups_by_maker(riglens):
    result = riglens("library")
    assert result.code == 0
    lines = [line.rstrip() for line in result.out.splitlines()]
    assert max(map(len, lines)) <= 100
    assert lines.index("Velodyne") < lines.index("Ouster") < lines.index("Hesai")
    row = next(line for line in lines if line.startswith("hesai-pandar64 "))
    assert row.split() == ["hesai-pandar64", "Pandar64", "64", "360°", "×", "39.8°", "0.3–200", "m"]


def test_a_kind_lists_that_kind_alone(riglens):
    lidars, cameras = (riglens("library", "--kind", kind).out for kind in ("lidar", "camera"))
    assert "generic-16" in lidars and "paper-camera-70" not in lidars
    assert "paper-camera-70" in cameras and "generic-16" not in cameras


def test_a_model_is_shown_with_beams_offsets_and_source(riglens):
    out = riglens("library", "velodyne-vlp-32c").out
    assert "ROS driver (BSD licence)" in out and "-15.64" in out and "positive turns left" in out
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 100


def test_json_holds_every_figure(riglens):
    document = json.loads(riglens("library", "--json").out)
    models = {model["name"]: model for model in document["models"]}
    assert document["riglens"] == 1 and len(models) > 40
    assert len(models["velodyne-vlp-32c"]["azimuth_offsets_deg"]) == 32
    assert models["generic-16"]["elevations_deg"] == {"from": -25.0, "to": 25.0, "count": 16}
    assert models["kitti-colour"]["distortion"]["k1"] == -0.3691
    assert all(len(model["source"]) > 30 for model in models.values())
    (one,) = json.loads(riglens("library", "generic-16", "--json").out)["models"]
    assert one == models["generic-16"]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("vlp-64",), "unknown sensor model 'vlp-64'"),
        (("generic-16", "--kind", "lidar"), "--kind lidar chooses what is listed"),
        (("--library", "/nowhere/own.yaml"), "/nowhere/own.yaml: no such file"),
    ],
)
def test_what_is_not_there_is_said_in_one_line(riglens, monkeypatch, arguments, complaint):
    monkeypatch.setenv("RIGLENS_LIBRARY", "")
    result = riglens("library", *arguments)
    assert (result.code, result.out) == (2, "")
    assert complaint in result.err and result.err.count("\n") == 1


def test_rigs_find_the_models_of_a_library_of_ones_own(riglens, boxes, tmp_path, monkeypatch):
    monkeypatch.setenv("RIGLENS_LIBRARY", "")
    (tmp_path / "own.yaml").write_text(OWN)
    (tmp_path / "rig.yaml").write_text(
        "riglens: 1\nname: own\nsensors:\n"
        "  - {name: a, kind: camera, model: my-cam, position: [0, 0, 2], cast: [16, 12]}\n"
    )
    small = ("--boxes", boxes, "--voxel", "0.5", "--roi", "20", "20", "4")
    assert riglens("evaluate", tmp_path / "rig.yaml", *small).code == 2
    own = ("--library", tmp_path / "own.yaml")
    assert riglens("evaluate", tmp_path / "rig.yaml", *small, *own).code == 0
    assert "my-cam" in riglens("library", *own).out
