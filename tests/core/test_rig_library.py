"""The library of sensor models: real angles, every entry usable, a wrong entry refused."""

from pathlib import Path

import pytest

from core.errors import InputError
from core.geometry import Pose
from core.rig.library import Entry, default_library, load_library, sensor_from_model
from core.rig.model import Camera, EvenAngles, Lidar
from core.rig.yaml_file import loads

ENTRIES = default_library().entries()


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.name)
def test_every_entry_makes_a_sensor_and_names_its_source(entry: Entry) -> None:
    pose = Pose((1.0, 2.0, 3.0), (0.0, 0.0, 90.0))
    sensor = sensor_from_model(entry.name, "mine", pose)
    assert (sensor.kind, sensor.name, sensor.model, sensor.pose) == (entry.kind, "mine", entry.name, pose)
    assert len(entry.source) > 30 and entry.title
    text = (
        f"{{name: mine, kind: {entry.kind}, model: {entry.name}, position: [1, 2, 3], rpy_deg: [0, 0, 90]}}"
    )
    assert loads(f"riglens: 1\nsensors: [{text}]").rig.sensors == (sensor,)


@pytest.mark.parametrize(
    ("model", "beams", "lowest_deg", "highest_deg", "azimuths"),
    [
        ("generic-16", 16, -25.0, 25.0, 360),
        ("velodyne-vlp-16", 16, -15.0, 15.0, 1800),
        ("velodyne-vlp-32c", 32, -25.0, 15.0, 1800),
        ("hesai-pandar64", 64, -24.879, 14.9, 1800),
        ("hesai-xt32", 32, -16.0, 15.0, 2000),
        ("ouster-os1-64", 64, -16.6, 16.6, 1024),
        ("ouster-os1-128", 128, -21.82, 20.95, 1024),
        ("robosense-rs-lidar-32", 32, -25.0, 15.0167, 1800),
    ],
)
def test_lidars_have_their_published_beams(
    model: str, beams: int, lowest_deg: float, highest_deg: float, azimuths: int
) -> None:
    lidar = sensor_from_model(model, "a", Pose())
    assert isinstance(lidar, Lidar)
    elevations = lidar.elevations()
    assert (elevations.size, elevations.min(), elevations.max()) == (beams, lowest_deg, highest_deg)
    assert (elevations[1:] > elevations[:-1]).all()
    assert lidar.azimuths().size == azimuths


def test_the_models_of_the_paper_are_the_defaults_of_the_paper() -> None:
    lidar = sensor_from_model("generic-16", "a", Pose())
    assert isinstance(lidar, Lidar) and lidar.elevations_deg == EvenAngles(from_=-25.0, to=25.0, count=16)
    for hfov_deg in (55, 70, 110):
        camera = sensor_from_model(f"paper-camera-{hfov_deg}", "a", Pose())
        assert isinstance(camera, Camera) and (camera.image, camera.hfov_deg) == ((1600, 900), hfov_deg)


def test_models_are_listed_by_kind() -> None:
    library = default_library()
    assert {entry.kind for entry in library.entries("camera")} == {"camera"}
    assert library.entries("lidar") + library.entries("camera") == library.entries()


def test_an_unknown_model_is_refused_with_the_known_ones() -> None:
    with pytest.raises(
        InputError, match=r"^model: unknown sensor model 'os1-64'; did you mean 'ouster-os1-64'\?"
    ):
        sensor_from_model("os1-64", "a", Pose())


SOURCE = "title: Some sensor, source: measured by hand in the yard"


@pytest.mark.parametrize(
    ("entry", "complaint"),
    [
        (f"x: {{kind: lidar, {SOURCE}, elevations_deg: [99]}}", "x: elevations_deg"),
        (f"x: {{kind: lidar, {SOURCE}}}", "x: elevations_deg"),
        (f"x: {{kind: lidar, {SOURCE}, elevations_deg: [1], beams: 3}}", "x: beams"),
        (f"x: {{kind: sonar, {SOURCE}}}", "x: kind"),
        ("x: {kind: lidar, title: Some sensor, elevations_deg: [1]}", "x: source: Field required"),
        (f"X y: {{kind: lidar, {SOURCE}, elevations_deg: [1]}}", "X y: name"),
        ("x: 3", "x: accepted are the fields of a sensor model"),
    ],
)
def test_a_wrong_library_is_refused_with_line_and_model(tmp_path: Path, entry: str, complaint: str) -> None:
    path = tmp_path / "library.yaml"
    path.write_text(f"# models\n{entry}\n")
    with pytest.raises(InputError) as caught:
        load_library(path)
    assert str(caught.value).startswith(f"library.yaml:2: {complaint}") and "\n" not in str(caught.value)
