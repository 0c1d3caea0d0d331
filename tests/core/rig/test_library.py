"""The library of sensor models: real angles, every entry usable, a wrong entry refused."""

import csv
import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.formats.mounts import find_model
from riglens.core.geometry import Pose
from riglens.core.rig.library import (
    Entry,
    changed_fields,
    default_library,
    read_entries,
    sensor_from_model,
    use_libraries,
    user_library_files,
)
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import dumps, loads
from riglens.core.sensors.camera import pixel_directions, project_px
from riglens.core.sensors.registry import kind_names

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
    assert isinstance(lidar, Lidar) and lidar.elevations_deg == LinearAngles(from_=-25.0, to=25.0, count=16)
    for hfov_deg in (55, 70, 110):
        camera = sensor_from_model(f"paper-camera-{hfov_deg}", "a", Pose())
        assert isinstance(camera, Camera) and (camera.image, camera.hfov_deg) == ((1600, 900), hfov_deg)


def test_models_are_listed_by_kind() -> None:
    library = default_library()
    assert {entry.kind for entry in library.entries("camera")} == {"camera"}
    assert tuple(entry for kind in kind_names() for entry in library.entries(kind)) == library.entries()


def test_an_unknown_model_is_refused_with_the_known_ones() -> None:
    with pytest.raises(
        InputError, match=r"^model: unknown sensor model 'os1-64'; did you mean 'ouster-os1-64' or"
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
        ("x: {kind: lidar, title: Some sensor, elevations_deg: [1]}", "x: source is missing"),
        (f"x: {{kind: lidar, {SOURCE}, elevations_deg: [1], range_at: {{2: 9}}}}", "x: range_at"),
        (f"x: {{kind: lidar, {SOURCE}, elevations_deg: [1], range_at: {{0.1: 9, 0.8: 3}}}}", "x: range_at"),
        (f"x: {{kind: lidar, {SOURCE}, elevations_deg: [1], range_at: {{1: 9, 1.0: 9}}}}", "x: range_at"),
        (f"x: {{kind: lidar, {SOURCE}, elevations_deg: [1], unverified: [range_m]}}", "x: unverified"),
        (f"x: {{kind: lidar, {SOURCE}, elevations_deg: [1], unverified: [title]}}", "x: unverified"),
        (f"x: {{kind: lidar, {SOURCE}, elevations_deg: [1], assumed: [range_m]}}", "x: assumed"),
        (
            f"x: {{kind: camera, {SOURCE}, image: [640, 480], hfov_deg: 60, range_at: {{0.1: 9}}}}",
            "x: range_at",
        ),
        (f"x: {{kind: lidar, {SOURCE}, elevations_deg: [1], other_names: [Pu-ck]}}", "x: other_names"),
        (f"X y: {{kind: lidar, {SOURCE}, elevations_deg: [1]}}", "X y: name"),
        (f"x: {{kind: lidar, {SOURCE}, elevations_deg: [1], r\ufeffange_m: [1, 2]}}", "x: 'r\\ufeffange_m'"),
        ("x: 3", "x: must be a mapping of the fields of a sensor model"),
    ],
)
def test_a_wrong_library_is_refused_with_line_and_model(tmp_path: Path, entry: str, complaint: str) -> None:
    path = tmp_path / "library.yaml"
    path.write_text(f"# models\n{entry}\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_entries(path, path.name)
    assert str(caught.value).startswith(f"library.yaml:2: {complaint}") and str(caught.value).isprintable()


def test_the_library_is_as_large_and_as_well_sourced_as_it_says() -> None:
    library = default_library()
    assert len(library.entries("lidar")) >= 61 and len(library.entries("camera")) >= 22
    assert all(entry.maker != "Other" for entry in library.entries())
    assert {name for name, origin in library.origins.items() if origin != "bundled"} == set()
    grouped = library.by_maker("lidar")
    assert [entry for entries in grouped.values() for entry in entries] == list(library.entries("lidar"))


@pytest.mark.parametrize("entry", default_library().entries("lidar"), ids=lambda entry: entry.name)
def test_beams_rise_and_steps_fit_the_azimuths(entry: Entry) -> None:
    lidar = entry.sensor("a", Pose())
    assert isinstance(lidar, Lidar) and isinstance(lidar.azimuths_deg, LinearAngles)
    assert (np.diff(lidar.elevations()) >= 0.0).all()
    if entry.azimuth_step_deg and "10" in entry.azimuth_step_deg:
        turn = lidar.azimuths_deg
        finest = (turn.to - turn.from_) / turn.count
        assert entry.azimuth_step_deg["10"] == pytest.approx(finest, rel=0.01) or entry.maker == "Ouster"


@pytest.mark.parametrize(
    ("model", "range_m"),
    [
        ("ouster-os0-32", (0.3, 50.0)),
        ("ouster-os1-128", (0.3, 120.0)),
        ("ouster-os2-128", (1.0, 240.0)),
        ("ouster-os0-128", (0.5, 75.0)),
        ("ouster-os1-128-rev7", (0.5, 170.0)),
        ("ouster-os2-128-rev7", (0.8, 350.0)),
        ("robosense-rs-lidar-16", (0.4, 150.0)),
        ("robosense-rs-lidar-32", (0.4, 200.0)),
        ("robosense-bpearl", (0.1, 100.0)),
        ("livox-mid-360", (0.1, 70.0)),
        ("generic-16", (0.0, 100.0)),
    ],
)
def test_ranges_follow_revision_and_decoder(model: str, range_m: tuple[float, float]) -> None:
    assert sensor_from_model(model, "a", Pose()).range_m == range_m


def test_ranges_by_reflectivity_rise_and_stay_within_the_instrument_range() -> None:
    anchored = [entry for entry in ENTRIES if entry.range_at]
    assert len(anchored) > 30
    for entry in anchored:
        anchors = entry.range_anchors()
        assert all(0.0 < share <= 1.0 for share, _ in anchors), entry.name
        assert [metres for _, metres in anchors] == sorted(metres for _, metres in anchors), entry.name
        assert anchors[-1][1] <= entry.sensor("a", Pose()).range_m[1], entry.name
    assert default_library().entry("ouster-os1-64").range_anchors() == ((0.1, 40.0), (0.8, 120.0))
    assert default_library().entry("generic-16").range_anchors() == ()


def test_tables_of_one_unit_and_disagreeing_sources_are_told() -> None:
    units = [entry for entry in ENTRIES if "one unit" in entry.source]
    assert len(units) > 10 and all("one unit" in entry.title for entry in units)
    for model, words in (
        ("hesai-at128", "180 m in the decoder and here, 200 m"),
        ("velodyne-vls-128", "245 m here, up to 200 m"),
    ):
        assert words in (default_library().entry(model).note or "")


def test_what_no_source_bears_out_is_marked() -> None:
    assert default_library().entry("ouster-os1-64").caveat() == ""
    et25 = default_library().entry("hesai-et25")
    assert et25.caveat() == "unverified: beams, azimuths, range"
    assert et25.origin().endswith("\nunverified: beams, azimuths, range")
    for entry in ENTRIES:
        assert "hird-party" not in entry.source or entry.unverified, entry.name


def test_a_range_that_is_our_choice_is_told_where_it_is_used() -> None:
    """The range law needs a range by reflectivity: where no source states one, it is assumed, and so is said."""
    library = default_library()
    assert library.entry("velodyne-vlp-16").origin().endswith("\nassumed: range by reflectivity")
    assert library.entry("generic-16").caveat() == "assumed: range"
    assert library.entry("hesai-jt128").caveat() == "unverified: range, azimuths"
    assert (
        library.entry("robosense-ruby-plus").caveat() == "unverified: beams; assumed: range by reflectivity"
    )
    assert library.entry("nuscenes-front").caveat() == ""


def test_the_lidar_of_nuscenes_is_an_hdl_32e_at_twice_the_rate() -> None:
    """46.08 microseconds a firing cycle, 20 turns a second."""
    own, plain = (sensor_from_model(name, "a", Pose()) for name in ("nuscenes-lidar-top", "velodyne-hdl-32e"))
    assert isinstance(own, Lidar) and isinstance(plain, Lidar)
    assert own.azimuths().size == round(1e6 / 20 / 46.08) == 1085
    assert plain.azimuths().size == round(1e6 / 10 / 46.08) == 2170
    assert own.elevations().tolist() == plain.elevations().tolist() and own.range_m == plain.range_m
    assert preset("nuScenes car").enabled_lidars()[0].model == "nuscenes-lidar-top"
    assert preset("nuScenes car").enabled_lidars()[0].ray_count == 32 * 1085


def test_the_rigs_of_the_paper_keep_their_unlimited_range() -> None:
    assert {lidar.range_m for lidar in preset("W+T").enabled_lidars()} == {(0.0, math.inf)}
    assert loads(dumps(preset("W+T"))).rig == preset("W+T")


def test_cameras_of_argoverse_are_told_apart_by_version() -> None:
    front, side = (sensor_from_model(f"argoverse2-{name}", "a", Pose()) for name in ("ring-front", "ring"))
    assert isinstance(front, Camera) and (front.image, round(front.fx or 0.0)) == ((1550, 2048), 1776)
    assert isinstance(side, Camera) and (side.image, round(side.fx or 0.0)) == ((2048, 1550), 1688)
    assert "Argoverse 1" in default_library().entry("argoverse-ring").title


def test_offsets_have_the_signs_of_a_turn_to_the_left() -> None:
    """Hesai's, Ouster's and RoboSense's tables count clockwise, the ROS driver of Velodyne the other way."""
    firsts = {
        "hesai-pandar64": (-24.879, 1.042),
        "hesai-at128": (-12.47, -0.65),
        "robosense-rs-lidar-32": (-25.0, 6.6968),
        "velodyne-vlp-32c": (-25.0, -1.4),
    }
    for model, (elevation, offset) in firsts.items():
        lidar = sensor_from_model(model, "a", Pose())
        assert isinstance(lidar, Lidar) and lidar.azimuth_offsets_deg is not None
        assert (lidar.elevations()[0], lidar.azimuth_offsets_deg[0]) == (elevation, offset)


def test_lidars_of_one_table_carry_the_angles_of_the_driver(shared_data: Path) -> None:
    for model, name in (("hesai-pandar40p", "Pandar40P"), ("hesai-qt128", "PandarQT128")):
        text = (shared_data / "beams" / "nebula" / f"{name}.csv").read_text(encoding="utf-8")
        rows = list(csv.reader(text.splitlines()))[1:]
        table = sorted((float(row[1]), -float(row[2])) for row in rows)
        lidar = sensor_from_model(model, "a", Pose())
        assert isinstance(lidar, Lidar) and lidar.azimuth_offsets_deg is not None
        found = list(zip(lidar.elevations(), lidar.azimuth_offsets_deg, strict=True))
        assert np.abs(np.array(found) - np.array(table)).max() < 1e-4


def test_a_field_of_view_in_the_file_replaces_lens_and_distortion_of_the_model() -> None:
    text = "riglens: 1\nsensors: [{name: a, kind: camera, model: kitti-colour, position: [0, 0, 1]%s}]"
    distorted, plain, straight = (
        loads(text % more).rig.sensors[0] for more in ("", ", hfov_deg: 80", ", distortion: null")
    )
    assert isinstance(distorted, Camera) and distorted.distortion is not None
    assert isinstance(plain, Camera) and (plain.distortion, plain.hfov_deg) == (None, 80.0)
    assert isinstance(straight, Camera) and (straight.distortion, straight.fx) == (None, 959.79)


def test_other_beams_than_the_models_go_without_its_offsets() -> None:
    text = "riglens: 1\nsensors: [{name: a, kind: lidar, model: velodyne-vlp-32c, position: [0, 0, 1]%s}]"
    full, few = (loads(text % more).rig.sensors[0] for more in ("", ", elevations_deg: [-1, 0]"))
    assert isinstance(full, Lidar) and len(full.azimuth_offsets_deg or ()) == 32
    assert isinstance(few, Lidar) and few.azimuth_offsets_deg is None


def test_a_rig_of_library_models_survives_a_save_without_spelling_them_out() -> None:
    text = """\
riglens: 1
sensors:
  - {name: a, kind: lidar, model: velodyne-vlp-32c, position: [0, 0, 2]}
  - {name: b, kind: camera, model: kitti-colour, position: [0, 0, 1.5]}
"""
    file = loads(text)
    moved = file.rig.with_sensor("b", file.rig.sensor("b").with_pose(Pose((0.5, 0.0, 1.5))))
    assert file.updated(moved).text == text.replace("[0, 0, 1.5]", "[0.5, 0, 1.5]")
    assert loads(dumps(moved)).rig == moved


def test_a_new_file_refers_to_bundled_models_unless_a_sensor_differs() -> None:
    pose = Pose((1.0, 0.0, 2.0))
    rig = Rig(sensors=tuple(sensor_from_model(entry.name, entry.name, pose) for entry in ENTRIES[:60]))
    text = dumps(rig)
    assert loads(text).rig == rig
    assert "elevations_deg" not in text and "azimuth_offsets_deg" not in text and "fx" not in text
    assert len(text) < 170 * len(rig.sensors)
    short = rig.sensors[4].replace(range_m=(0.0, 30.0))
    line = dumps(Rig(sensors=(short,)))
    assert "range_m: [0.0, 30.0]" in line and "elevations_deg" not in line
    assert loads(line).rig.sensors == (short,)


def test_a_new_file_holds_every_figure_of_a_model_of_ones_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RIGLENS_LIBRARY", str(own_library(tmp_path, OWN)))
    text = dumps(Rig(sensors=(sensor_from_model("my-lidar", "a", Pose()),)))
    assert "elevations_deg: [-10.0, 0.0, 5.5]" in text and "azimuth_offsets_deg" in text


OWN = """\
my-lidar:
  kind: lidar
  title: LiDAR of our own
  source: Measured on the bench in March
  body_m: {diameter: 0.1, height: 0.08}
  elevations_deg: >-
    -10, 0
    5.5
  azimuth_offsets_deg: [1, 0, -1]
"""


def own_library(folder: Path, text: str) -> Path:
    path = folder / "own.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_models_of_ones_own_are_found_beside_the_bundled_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = own_library(tmp_path, OWN)
    monkeypatch.setenv("RIGLENS_LIBRARY", str(path))
    lidar = sensor_from_model("my-lidar", "a", Pose())
    assert isinstance(lidar, Lidar) and lidar.elevations().tolist() == [-10.0, 0.0, 5.5]
    assert default_library().entry("my-lidar").maker == "Other"
    assert default_library().origins["my-lidar"] == str(path)
    assert default_library().entry("generic-16")
    second = tmp_path / "second.yaml"
    second.write_text(OWN.replace("my-lidar", "second-lidar"), encoding="utf-8")
    use_libraries([second])
    assert default_library().entry("my-lidar") and default_library().entry("second-lidar")
    monkeypatch.delenv("RIGLENS_LIBRARY")
    with pytest.raises(InputError, match="unknown sensor model 'my-lidar'"):
        default_library().entry("my-lidar")


def test_the_configuration_folder_is_looked_into(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIGLENS_CONFIG_DIR", str(tmp_path))
    assert user_library_files() == ()
    (tmp_path / "library.yaml").write_text(OWN, encoding="utf-8")
    assert sensor_from_model("my-lidar", "a", Pose()).kind == "lidar"


def test_other_programs_call_a_model_of_our_own_by_its_other_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RIGLENS_CONFIG_DIR", str(tmp_path))
    (tmp_path / "library.yaml").write_text(f"{OWN}  other_names: [benchpuck]\n", encoding="utf-8")
    found = find_model("velodyne_bench_puck_link")
    assert find_model("bench_rabbit") is None and found is not None and found.name == "my-lidar"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (
            OWN.replace("my-lidar", "generic-16"),
            ": generic-16: name already used in the library (bundled)",
        ),
        (
            OWN.replace("-10, 0", "-10, o"),
            ":1: my-lidar: elevations_deg: must be angles in degrees (got 'o')",
        ),
        (OWN.replace("[1, 0, -1]", "[1, 0]"), ":9: my-lidar: azimuth_offsets_deg"),
        (OWN.replace("0.08", ".nan"), ":5: my-lidar: body_m"),
        (OWN + "  position: [0, 0, 1]\n", ":1: my-lidar: position: not a field of a model"),
        (OWN + "  pixel_um: 3\n", ":1: my-lidar: pixel_um: not a figure of a lidar"),
        (OWN + "  azimuths_deg: {from: 0, to: 360, count: 100001}\n", ":10: my-lidar: azimuths_deg"),
        ("", ":1: the file is empty"),
        ("- 1\n", ":1: a sensor library must be a mapping of model names"),
        ("".join(f"m{i}: 3\n" for i in range(501)), ": must have at most 500 models (got 501)"),
        ("a: &x 1\nb: *x\n", ":1: anchors and aliases"),
    ],
)
def test_a_wrong_library_of_ones_own_is_refused_with_file_line_and_field(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, complaint: str
) -> None:
    path = own_library(tmp_path, text)
    monkeypatch.setenv("RIGLENS_LIBRARY", str(path))
    with pytest.raises(InputError) as caught:
        default_library()
    assert str(caught.value).startswith(f"{path}{complaint}"), str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_or_huge_library_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIGLENS_LIBRARY", str(tmp_path / "none.yaml"))
    with pytest.raises(InputError, match=r"none\.yaml: no such file"):
        default_library()
    monkeypatch.setenv("RIGLENS_LIBRARY", str(own_library(tmp_path, "#" * 4_100_000)))
    with pytest.raises(InputError, match="too large for a sensor library"):
        default_library()


def test_a_sensor_says_in_what_it_differs_from_its_model() -> None:
    lidar = sensor_from_model("velodyne-vlp-16", "top", Pose((0.0, 0.0, 2.0), (0.0, 0.0, 90.0)))
    assert isinstance(lidar, Lidar)
    assert changed_fields(lidar) == ()
    assert changed_fields(lidar.replace(enabled=False, name="other")) == ()
    listed = tuple(float(angle) for angle in lidar.azimuths())
    assert changed_fields(lidar.replace(azimuths_deg=listed)) == ()
    fewer = lidar.replace(elevations_deg=tuple(lidar.elevations()[:8]))
    assert changed_fields(fewer) == ("elevations_deg",)
    assert changed_fields(lidar.replace(range_m=(0.0, 30.0))) == ("range_m",)
    assert changed_fields(fewer.replace(model=None)) == ()
    assert changed_fields(fewer.replace(model="nobody-knows-1")) == ()


def test_the_woodscape_fisheye_images_where_its_published_polynomial_does() -> None:
    camera = sensor_from_model("valeo-woodscape-fisheye", "cam", Pose())
    assert isinstance(camera, Camera)
    angle = np.radians(np.linspace(0.1, 100.0, 500))
    published = 339.749 * angle - 31.988 * angle**2 + 48.275 * angle**3 - 7.201 * angle**4
    found = project_px(camera, np.stack([np.cos(angle), -np.sin(angle), np.zeros(500)], axis=1))
    assert np.abs(found[:, 0] - 643.942 - published).max() < 0.43


def test_the_readme_counts_the_models_of_the_library() -> None:
    number = Counter(entry.kind for entry in ENTRIES)
    page = (Path(__file__).resolve().parents[3] / "README.md").read_text(encoding="utf-8")
    assert f"{number['lidar']} LiDARs, {number['camera']} cameras, {number['radar']} radars" in page


def test_wide_lenses_of_cars_compress_their_borders() -> None:
    """A car ahead is not smaller in the picture than one aside, so its range is not below that at 45 degrees."""
    cameras = [
        default_library().entry(name).sensor("a", Pose())
        for name in ("sekonix-sf3324", "generic-front-8mp-120")
    ]
    cameras += [sensor for sensor in preset("production car").sensors if isinstance(sensor, Camera)]
    for camera in cameras:
        assert isinstance(camera, Camera)
        width, height = camera.image
        edges = [(at, height / 2.0) for at in np.linspace(0.0, width, 201)]
        rays = pixel_directions(camera, np.array(edges))
        azimuths = np.degrees(np.arctan2(rays[:, 1], rays[:, 0]))
        density = (width / 200.0) / np.abs(np.diff(azimuths))
        ahead, aside = density[100], density[np.argmin(np.abs(azimuths[:-1] - 45.0))]
        assert np.abs(azimuths).max() < 50.0 or ahead >= 0.999 * aside, camera.model
