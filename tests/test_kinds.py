"""A new kind of sensor is one declaration: a probe, made up here, goes through the whole product.

What the program does not know of probes it reports; nothing takes one for a camera or a LiDAR.
"""

import ast
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from pydantic import Field, ValidationError
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel
from pytestqt.qtbot import QtBot

import riglens as rl
from riglens.app.terminal.scores import score_table
from riglens.core.blind.zones import BlindEngine, BlindSettings, unseen_by
from riglens.core.engine.audit import audit
from riglens.core.engine.engine import Engine
from riglens.core.engine.evaluation_json import evaluation_document
from riglens.core.errors import InputError
from riglens.core.figures.documents import objects_document
from riglens.core.figures.registry import maps
from riglens.core.formats.exchange import FORMATS, writable
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS, MetricSettings
from riglens.core.review.documents import blind_document
from riglens.core.review.profiles import Profile
from riglens.core.review.redundancy import target_coverage, voxel_coverage
from riglens.core.rig.history import History, describe
from riglens.core.rig.model import Lidar, Rig, Vehicle
from riglens.core.rig.yaml.file import dumps, loads
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import unpack
from riglens.core.sensing.rays import sensor_rays
from riglens.core.sensors import registry
from riglens.core.sensors.base import Sector, Sensor
from riglens.core.sensors.kind import HitMeasure, Occlusion, Placement, SensorKind
from riglens.core.sensors.lattice import Ids
from riglens.core.sensors.mounting import outwards_rpy_deg
from riglens.core.sensors.registry import kind_of, kinds, registered
from riglens.core.targets.detection_range import RangePlan
from riglens.core.targets.detection_range_making import detection_range_of
from riglens.core.targets.detection_range_table import range_document, range_lines
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.object_table import object_table
from riglens.core.targets.settings import EXACT
from riglens.core.vehicle.placing import placed_on
from riglens.core.vehicle.solid import solid_of
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.rendering.picture import Findings, subtitle
from riglens.reporting.document import document_of
from riglens.reporting.figures import ReportPlan, report_of
from riglens.reporting.page import report_page
from riglens.widgets.panels.fields.edits import NumberEdit
from riglens.widgets.panels.fields.quantity import DEGREES
from riglens.widgets.panels.inspector.panel import Inspector
from riglens.widgets.panels.sensors.tree import SensorTree
from riglens.widgets.sensors.appearance import PLAIN, appearance_of
from riglens.widgets.sensors.ray_key import entries_of
from riglens.widgets.sensors.ray_look import RayLook
from riglens.widgets.theme import DARK
from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.still import render_still
from tests.core.builders import camera, field_of, grid_of, random_field, seen_ray_by_ray, spinning
from tests.core.targets.cases import parts, traffic
from tests.core.vehicle.solids import body_ends

REPOSITORY = Path(__file__).resolve().parents[1]
GRID = grid_of(40, 40, 8, 0.5)
LOW = Vehicle(length=3.0, width=1.5, height=1.2)


# ---------------------------------------------------------------- the declaration


class Probe(Sensor):
    """Rays in rings around its axis, which fill a cone."""

    kind: Literal["probe"] = "probe"
    opening_deg: Annotated[float, Field(gt=0.0, le=90.0)] = 40.0
    rings: Annotated[int, Field(ge=1, le=100)] = 12

    @property
    def resolution(self) -> tuple[int, int]:
        return 24, self.rings


def directions(probe: Probe, rays: Ids) -> NDArray[np.float64]:
    around, rings = probe.resolution
    off_axis = np.radians(probe.opening_deg / 2.0) * (rays // around + 1) / rings
    turn = 2.0 * np.pi * (rays % around) / around
    return np.stack(
        [np.cos(off_axis), np.sin(off_axis) * np.cos(turn), np.sin(off_axis) * np.sin(turn)], axis=-1
    )


PROBE = SensorKind(
    name="probe",
    title="probe",
    plural="probes",
    model=Probe,
    directions=directions,
    view_deg=lambda probe: (probe.opening_deg, probe.opening_deg),
    brief=lambda probe: f"{probe.opening_deg:g}°",
    size=("rings", lambda probe: f"{probe.rings}"),
    summary=lambda probe: [("Rays", f"{probe.ray_count}"), ("Opening", f"{probe.opening_deg:g}°")],
    occlusion=Occlusion(housing_radius_m=0.02),
    placement=Placement(above_roof_m=0.0, rpy_deg=outwards_rpy_deg, away_when_level=True),
    hits=HitMeasure("returns", threshold=3, label="echoes", unit="echoes"),
)


# ---------------------------------------------------------------- what follows from it


@pytest.fixture(autouse=True)
def _known() -> Iterator[None]:
    with registered(PROBE):
        yield


def probe(name: str = "probe", **fields: object) -> Probe:
    return Probe(**({"name": name, "position": (0.0, 0.0, 1.5)} | fields))  # type: ignore[arg-type]


def rig_with(*sensors: Sensor) -> Rig:
    return Rig(name="three kinds", vehicle=LOW, sensors=sensors)


EYE, TOP = camera((0.0, 0.0, 1.6)).replace(name="eye"), spinning((0.0, 0.0, 1.6)).replace(name="top")


def test_a_kind_is_known_while_it_is_registered() -> None:
    assert [kind.name for kind in kinds()] == ["lidar", "camera", "radar", "ultrasonic", "probe"]
    assert kind_of(probe()) is PROBE
    with pytest.raises(ValueError, match="kind 'probe' already exists"), registered(PROBE):
        pass


def test_a_rig_file_holds_it_and_says_what_its_fields_accept() -> None:
    rig = rig_with(TOP, probe(opening_deg=60.0, rpy_deg=(0.0, 10.0, 90.0)))
    text = dumps(rig)
    assert "kind: probe" in text and "opening_deg: 60" in text
    assert loads(text).rig == rig
    with pytest.raises(InputError, match=r'probe "probe": opening_deg must be at most 90 \(got 200'):
        loads(text.replace("opening_deg: 60", "opening_deg: 200"))
    with pytest.raises(
        InputError, match=r"kind must be lidar or camera or radar or ultrasonic or probe \(got sonar"
    ):
        loads(text.replace("kind: probe", "kind: sonar"))
    with pytest.raises(ValidationError):
        rig.replace(sensors=({"name": "a", "kind": "sonar", "position": (0.0, 0.0, 0.0)},))


def test_an_edit_of_it_is_one_step_that_can_be_undone() -> None:
    before = rig_with(TOP, probe())
    after = before.with_sensor("probe", probe(opening_deg=20.0))
    history = History(before)
    edit = describe(before, after)
    assert edit.numbers == {("sensors", 1, "opening_deg")} and history.apply(edit.label, after)
    assert history.undo() and history.rig == before
    assert history.redo() and history.rig == after


def test_it_is_cast_exactly_and_scored_beside_the_others() -> None:
    field = random_field(GRID, np.random.default_rng(1))
    known, more = rig_with(TOP, EYE), rig_with(TOP, EYE, probe(rpy_deg=(0.0, 12.0, 30.0)))
    without, found = (Engine(field, 1).evaluate(rig) for rig in (known, more))
    mine = unpack(GRID, found.seen["probe"])
    assert np.array_equal(mine, seen_ray_by_ray(field, more.sensors[2])) and mine.any()
    for name in CLASSES:
        old, new = without.scores.classes[name], found.scores.classes[name]
        assert new.kinds["probe"].seen > 0.0 and old.kinds["probe"].seen == 0.0
        assert (new.s_ms, new.lidar, new.camera) == (old.s_ms, old.lidar, old.camera)
        assert new.any_seen > old.any_seen
    seen = np.bitwise_or.reduce([found.seen[kind.name] for kind in kinds()])
    assert np.array_equal(seen, found.seen_by_any())
    written = evaluation_document(field, PAPER_SETTINGS, [found])["rigs"][0]
    assert list(written["classes"]["car"]) == ["h_total", "camera", "lidar", "probe", "any", "s_ms"]
    assert written["covered_voxels"]["probe"] == mine.sum()
    headings = [str(column.header) for column in score_table([found]).columns]
    assert headings[-4:] == ["seen\ncamera", "seen\nLiDAR", "seen\nprobe", "seen\nany"]


def test_edits_among_three_kinds_give_the_scores_of_evaluations_from_scratch() -> None:
    field, rng = random_field(GRID, np.random.default_rng(2)), np.random.default_rng(3)
    engine = Engine(field, 1)
    for _ in range(12):
        turn = (0.0, float(rng.uniform(0.0, 40.0)), float(rng.uniform(-180.0, 180.0)))
        chosen = [s for s in (TOP, EYE, probe(rpy_deg=turn), probe("other")) if rng.random() < 0.7]
        rig = rig_with(*chosen)
        assert engine.evaluate(rig).scores == Engine(field, 1).evaluate(rig).scores


def test_the_cars_body_stops_its_rays_and_the_audit_says_which() -> None:
    field, inside = field_of(GRID), rig_with(probe(position=(0.0, 0.0, 0.8)))
    (found,) = audit(Engine(field), inside).sensors
    assert found.kind == "probe" and found.counts["hits_car"] > 0 and found.lost_nat["car"] > 0.0
    ends = body_ends(inside.sensors[0], solid_of(LOW))
    assert np.isfinite(ends).sum() == found.counts["hits_car"]
    free, blocked = (
        Engine(field, 1).evaluate(inside, MetricSettings(body=body)).scores.classes["car"].kinds["probe"]
        for body in ("ignored", "blocks")
    )
    assert found.lost_nat["car"] == blocked.s_mig - free.s_mig


def test_it_sits_on_a_surface_as_its_kind_says() -> None:
    corners = np.array([[-0.01, -0.01, -0.01], [0.0, 0.01, 0.01]])
    side = placed_on(np.array([0.0, 0.8, 0.6]), np.array([0.0, 1.0, 0.0]), "probe", corners)
    assert side.rpy_deg == (0.0, 0.0, 90.0) and side.position_m == (0.0, 0.81, 0.6)


def test_what_it_gets_from_objects_counts_towards_what_is_detected() -> None:
    held = traffic([(0, 0, (6.0, 0.0, 0.8), (4.5, 1.9, 1.6), 0.3)])
    engine = TargetEngine(held, 1)
    found = engine.evaluate(rig_with(TOP.replace(enabled=False), probe()), EXACT)
    echoes = found.objects.returns["probe"]
    origin, hit = np.array([0.0, 0.0, 1.5]), 0
    for way in sensor_rays(probe()).directions:  # independently: every ray against the box
        hit += _meets(origin, way, (6.0, 0.0, 0.8), (4.5, 1.9, 1.6), 0.3)
    assert echoes.names == ("probe",) and echoes.counts.tolist() == [[hit]] and hit > 3
    total = parts(found)["car"].total
    assert (total["probe"].value, total.missed.value, total.both.value) == (1.0, 0.0, 0.0)
    assert object_table(found)["echoes_probe"].to_pylist() == [hit]
    written = objects_document([found])["rigs"][0]["classes"]["car"]
    share = {"share": 1.0, "share_se": 0.0}
    assert written["probe"] == share and written["rings"][0]["probe"] == share
    dense = spinning((0.0, 0.0, 1.6), beams=32, count=720).replace(name="dense")
    both = engine.evaluate(rig_with(dense, probe()), EXACT)
    covered = target_coverage(both)
    assert covered.covered.sum(axis=(0, 2)).tolist() == [1, 1, 0, 1]  # by 1, 2, 3 sensors, by two kinds


def _meets(origin: NDArray[np.float64], way: NDArray[np.float64], *box: object) -> bool:
    """Whether a ray meets an upright box: centre, size, yaw."""
    centre, size, yaw = np.array(box[0]), np.array(box[1]), float(box[2])  # type: ignore[arg-type]
    turn = np.array([[np.cos(yaw), np.sin(yaw), 0.0], [-np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    start, along = turn @ (origin - centre), turn @ way
    with np.errstate(divide="ignore"):
        enter, leave = np.sort(np.stack([(-size / 2 - start) / along, (size / 2 - start) / along]), axis=0)
    return bool(max(enter.max(), 0.0) < leave.min())


def test_the_detection_range_says_up_to_which_distance_it_detects() -> None:
    ahead = RangePlan(bearings_deg=(0.0,), to_m=40.0)
    ranges = detection_range_of(rig_with(TOP, probe(range_m=(0.0, 20.0))), ahead, 1)
    far = {row.cls: row.reaches["probe"].most_m for row in ranges.rows}
    assert 0.0 < far["pedestrian"] < 22.0 and 20.0 < far["car"] < 24.0
    assert range_document(ranges)["rigs"][0]["rows"][0]["probe"]["first_below_m"]
    assert {line["kind"]: line["threshold"] for line in range_lines(ranges)} == {
        "lidar": 5,
        "camera": 25.0,
        "probe": 3,
    }


class ImageProbe(Probe):
    """A probe whose rays make an image: what is 3 rows tall in one of them is detected."""

    kind: Literal["image"] = "image"  # type: ignore[assignment]


IMAGE = replace(
    PROBE, name="image", model=ImageProbe, hits=HitMeasure("pixels", threshold=3, label="px", unit="px")
)


def test_rows_of_pixels_of_another_kind_than_cameras_count_in_the_image_that_shows_most() -> None:
    held = traffic([(0, 0, (6.0, 0.0, 0.8), (4.5, 1.9, 1.6), 0.3)])
    left, right = (
        ImageProbe(name=name, position=(0.0, 0.0, z)) for name, z in (("left", 1.5), ("right", 1.2))
    )
    with registered(IMAGE):
        found = TargetEngine(held, 1).evaluate(rig_with(left, right), EXACT)
        rows = found.objects.returns["image"]
        both = [_rows_on_object(one) for one in (left, right)]
        assert rows.counts.tolist() == [both] and rows.without(()).tolist() == [max(both)] and max(both) >= 3
        assert rows.without(("left", "right")).tolist() == [0]
        share = parts(found)["car"].total
        assert (share["image"].value, share.missed.value) == (1.0, 0.0)
        ranges = detection_range_of(
            rig_with(left), RangePlan(bearings_deg=(0.0,), to_m=40.0, min_height_px=9.0), 1
        )
        assert {line["kind"]: line["threshold"] for line in range_lines(ranges)}["image"] == 3
        assert {row.cls: row.reaches["image"].most_m for row in ranges.rows}["car"] > 6.0


def _rows_on_object(probe: ImageProbe) -> int:
    """Rows from the first to the last ring with a ray on the object, each ray against its box."""
    rays, around = sensor_rays(probe), probe.resolution[0]
    origin = np.array(probe.position)
    met = [_meets(origin, way, (6.0, 0.0, 0.8), (4.5, 1.9, 1.6), 0.3) for way in rays.directions]
    rows = np.flatnonzero(met) // around
    return int(rows.max() - rows.min() + 1)


def test_blind_zones_and_profiles_ask_for_it_by_name() -> None:
    rig = rig_with(TOP, probe(rpy_deg=(0.0, 45.0, 0.0)))
    found = BlindEngine(rig.vehicle, BlindSettings(voxel_m=0.25, within_m=5.0), threads=1).evaluate(rig)
    mine, any_sensor = (found.area_m2(0.8, by).sum() for by in ("probe", "any"))
    assert any_sensor <= mine and unseen_by("probe", 1) == "unseen by any probe"
    nothing = found.area_m2(0.8, "camera").sum()
    assert mine < nothing
    assert {zone["by"] for zone in blind_document(found, ())["zones"]} == {"any", "camera", "lidar", "probe"}
    made = {"name": "x", "title": "a title", "source": "a source of it", "object": {}, "at": ()}
    with pytest.raises(ValidationError, match="'any', 'camera', 'lidar', 'probe', 'radar' or 'ultrasonic'"):
        Profile.model_validate(made | {"by": "sonar"})


def test_redundancy_counts_two_kinds_among_three() -> None:
    field = random_field(GRID, np.random.default_rng(4))
    rig = rig_with(TOP, EYE, probe(), probe("other", rpy_deg=(0.0, 0.0, 20.0)))
    engine = Engine(field, 1)
    seen = [unpack(GRID, words) for words in engine.evaluate(rig).seen.values()]
    covered = voxel_coverage(engine, rig).covered[:, 3].sum(axis=0)
    two_kinds = np.sum(seen, axis=0) >= 2
    assert covered.tolist() == _entropy_q(field, two_kinds)
    assert np.array_equal(unpack(GRID, engine.evaluate(rig).seen_by_two_kinds()), two_kinds)


def _entropy_q(field: EntropyField, mask: NDArray[np.bool_]) -> list[int]:
    i, j, k = field.index.ijk().T
    chosen = mask[i, j, k]
    return [int(field.entropies_q[field.codes()[chosen], cls].sum()) for cls in range(len(CLASSES))]


@pytest.mark.parametrize("name", [name for name in writable() if name != "riglens"])
def test_no_other_format_drops_it_in_silence(name: str) -> None:
    written = FORMATS[name].write(rig_with(TOP, EYE, probe()))
    assert any("probe: " in line and "(probe)" in line for line in written.report.lines())
    assert not any("probe" in text for text in written.files.values() if isinstance(text, str))


def test_the_python_interface_scores_it(tmp_path: Path) -> None:
    path = tmp_path / "boxes.csv"
    rows = (
        "seq,frame,cls,x,y,z,length,width,height,yaw",
        "s,0,car,6,0,0.8,4,2,1.6,0",
        "s,1,bicycle,3,-4,0.9,2,0.6,1.7,0",
        "s,2,pedestrian,2,5,0.9,0.6,0.6,1.8,0",
    )
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    scene = rl.load_scene(path, 0.5, roi_m=(20.0, 20.0, 4.0))
    result = rl.score(rig_with(TOP, probe()), scene)
    assert result["car"].by_kind["probe"].seen > 0.0 and result["car"].seen >= result["car"].seen_lidar


# ---------------------------------------------------------------- the window


def test_the_list_of_sensors_has_a_group_for_it(qtbot: QtBot) -> None:
    tree = SensorTree()
    qtbot.addWidget(tree)
    tree.set_rig(rig_with(TOP, EYE, probe()), frozenset(), ("probe",))
    groups = [tree.topLevelItem(place) for place in range(tree.topLevelItemCount())]
    assert [group.text(0) for group in groups if group] == ["LiDARs  1", "Cameras  1", "Probes  1"]
    menu = [action.text() for action in tree.context_menu().actions()]
    assert "Select all probes" in menu and "Select all LiDARs" in menu


def test_the_inspector_edits_its_fields(qtbot: QtBot) -> None:
    inspector, edited = Inspector(), list[dict[str, Sensor]]()
    qtbot.addWidget(inspector)
    inspector.sensors_edited.connect(edited.append)
    inspector.set_rig(rig_with(TOP, probe()), ("probe",))
    opening = inspector.form.findChild(NumberEdit, "opening_deg")
    assert opening is not None and opening.text() == "40" and opening.unit == DEGREES
    opening.setText("95")
    opening.textEdited.emit("95")
    opening.setModified(True)
    qtbot.keyClick(opening, Qt.Key.Key_Return)
    assert edited == [] and "90" in inspector.form.problem
    qtbot.keyClick(opening, Qt.Key.Key_Escape)
    opening.step_by(20)
    assert edited == [{"probe": probe(opening_deg=60.0)}]
    derived = inspector.form.findChild(QLabel, "Opening")
    assert derived is not None and derived.text() == "40°"


class TunedProbe(Probe):
    """A probe with fields for which a form has no input."""

    kind: Literal["tuned"] = "tuned"  # type: ignore[assignment]
    sector: Sector | None = None
    gains: dict[str, float] = Field(default_factory=dict)
    power: float = 1.0


def test_fields_without_an_input_are_left_to_the_rig_file(qtbot: QtBot) -> None:
    with registered(replace(PROBE, name="tuned", model=TunedProbe)):
        inspector = Inspector()
        qtbot.addWidget(inspector)
        inspector.set_rig(rig_with(TunedProbe(name="tuned", position=(0.0, 0.0, 1.0))), ("tuned",))
        found = {edit.objectName() for edit in inspector.form.findChildren(NumberEdit)}
    assert {"power", "opening_deg"} <= found and not {"sector", "gains"} & found


def test_a_kind_derived_from_another_looks_like_it_in_other_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    class Scanner(Lidar):
        kind: Literal["scanner"] = "scanner"  # type: ignore[assignment]

    look = appearance_of("lidar")
    with registered(replace(kind_of("lidar"), name="scanner", model=Scanner)):
        derived = appearance_of("scanner")
    assert derived == replace(look, colour=PLAIN.colour, ray_colours=PLAIN.ray_colours) != look
    assert appearance_of("probe") == PLAIN
    monkeypatch.setitem(registry.BUILT_IN, "probe", PROBE)
    assert appearance_of("probe") == PLAIN


def test_its_body_and_its_rays_are_drawn_with_a_key() -> None:
    state = SceneState(rig=rig_with(probe(rpy_deg=(0.0, 30.0, 0.0))), show_gizmo=False, show_legend=False)
    rays = picture(replace(state, ray_look=RayLook(of_all=True)))
    bare = picture(replace(state, ray_look=RayLook(shown=False)))
    empty = picture(replace(state, rig=rig_with(), ray_look=RayLook(shown=False)))
    assert (rays != bare).any() and (bare != empty).any()
    filled = picture(replace(state, ray_look=RayLook(shown=False, fill="frusta")))
    assert (filled != bare).any()
    key = entries_of([probe(), TOP], probe("other"), DARK)
    assert [entry.words for entry in key] == ["LiDAR", "probe"]
    assert len({entry.colour for entry in key}) == 2


def picture(state: SceneState) -> NDArray[np.uint8]:
    return render_still(state, (160, 100))


def test_the_map_offers_what_it_sees() -> None:
    shown = {one.key: one.on_map for one in maps()}
    assert shown["probe"] == "entropy seen by probes" and shown["lowest_2_probe"].endswith("seen by 2 probes")


def test_a_picture_counts_it() -> None:
    field, rig = random_field(GRID, np.random.default_rng(5)), rig_with(TOP, probe())
    scores = Engine(field, 1).evaluate(rig).scores
    assert subtitle(Findings(rig, scores, PAPER_SETTINGS, field)).startswith("0 cameras, 1 LiDAR, 1 probe")


# ---------------------------------------------------------------- nothing else compares kinds

MAY_NAME_KINDS = {
    "riglens/jobs/simulating.py": "data sets have the LiDAR and camera channels of nuScenes",
    "riglens/studies/accuracy_text.py": "studies of the paper's methods, on its LiDARs and cameras",
    "app/window/features/propose.py": "proposals are LiDARs",
    "app/window/features/sweep_field.py": "hit coverage is of LiDARs, 25 px of cameras",
    "app/commands/footprint.py": "pixels per metre are of cameras",
    "core/footprint": "pixels per metre are of cameras",
    "widgets/panels/sensors/rows.py": "pixels per metre are of cameras",
    "widgets/sensors/footprints.py": "pixels per metre are of cameras",
    "widgets/viewport/inset.py": "pictures are of cameras",
    "widgets/viewport/place_words.py": "cameras have an aim and a width of view",
    "widgets/viewport/words_layer.py": "pixels per metre are of cameras",
    "riglens/studies/paper_sheet.py": "the paper's groups are of LiDARs and of cameras",
    "core/formats": "each format has its own words for each kind",
    "core/metric/scores.py": "the two kinds of the paper have accessors of their own",
    "core/figures/hits.py": "hit coverage is of LiDARs, 25 px of cameras",
    "core/figures/predicted.py": "predicted AP is of LiDARs and of cameras",
    "core/optimise/chances.py": "pictures show a share of objects",
    "core/optimise/makers.py": "points and cells are of LiDARs, heights in pictures of cameras",
    "core/optimise/objectives.py": "S-MS is of LiDARs here",
    "core/rig/plausible.py": "cameras lie on their side, LiDARs may be sonars",
    "core/sensors": "declares them",
    "core/simulate": "data sets have the LiDAR and camera channels of nuScenes",
    "core/study": "studies of the paper's methods, on its LiDARs and cameras",
    "core/sweep/curve.py": "hit coverage is of LiDARs, 25 px of cameras",
    "core/targets": "has figures of their own for LiDARs and cameras",
    "widgets/sensors/appearance.py": "appearance",
    "widgets/viewport/drawn_scene.py": "the camera of the view",
}
"""Files and folders that may compare kinds of sensor, and why."""
BUILT_IN = {kind.name: kind.model.__name__ for kind in kinds()}
NAMES = re.compile("|".join({*BUILT_IN, *BUILT_IN.values(), *map(str.upper, BUILT_IN)}))


def compares_kinds(source: str) -> bool:
    """Return whether a file names a kind, uses its descriptor, or asks whether something is one of its sensors.

    A sensor may be called so (`name="camera"`), and functions for one kind may be registered by its class, since those
    have no branch for all others.
    """
    if not NAMES.search(source):
        return False
    every = list(ast.walk(ast.parse(source)))
    descriptors, models, names_of_sensors = set(), set(BUILT_IN.values()), set()
    for node in every:
        if isinstance(node, ast.ImportFrom):
            kind = (node.module or "").removeprefix("riglens.core.sensors.")
            if kind in BUILT_IN:
                descriptors |= {one.asname or one.name for one in node.names if one.name == kind.upper()}
            models |= {one.asname or one.name for one in node.names if one.name in models}
        if isinstance(node, ast.Call):
            names_of_sensors |= {id(word.value) for word in node.keywords if word.arg == "name"}
    for node in every:
        if isinstance(node, ast.Constant) and node.value in BUILT_IN and id(node) not in names_of_sensors:
            return True
        if isinstance(node, ast.Name) and node.id in descriptors:
            return True
        asked = list[ast.expr | None]()
        if isinstance(node, ast.Call) and _called(node.func) in ("isinstance", "issubclass"):
            asked = list(node.args[1:])
        elif isinstance(node, ast.Compare):
            asked = [node.left, *node.comparators]
        elif isinstance(node, ast.Dict):
            asked = list(node.keys)
        elif isinstance(node, ast.MatchClass):
            asked = [node.cls]
        if any(_called(part) in models for one in asked if one is not None for part in ast.walk(one)):
            return True
    return False


def _called(node: ast.AST) -> str:
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


_IMPORTED = (
    "from riglens.core.rig.model import Camera as Eye, Lidar\nfrom riglens.core.sensors.radar import RADAR\n"
)


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("sensor.kind == RADAR.name", True),
        ("kind is RADAR", True),
        ("sensor.kind in ('radar', 'ultrasonic')", True),
        ("isinstance(sensor, (int, Eye))", True),
        ("isinstance(sensor, model.Ultrasonic)", True),
        ("isinstance(sensor, Lidar | None)", True),
        ("type(sensor) is Lidar", True),
        ("{Lidar: 1}[type(sensor)]", True),
        ("match sensor:\n    case Lidar():\n        pass", True),
        ("match sensor.kind:\n    case 'lidar':\n        pass", True),
        ("RADAR = 3\nSensor(name='lidar', kind=kind.name)", False),
        ("kind_of(sensor) is kind and sensor.kind == kind.name", False),
        ("def _of(lidar: Lidar) -> Eye:\n    'A camera.'", False),
    ],
)
def test_a_comparison_of_kinds_is_found_however_it_is_written(source: str, expected: bool) -> None:
    imported = _IMPORTED.splitlines()[0] + "\n" if source.startswith("RADAR =") else _IMPORTED
    assert compares_kinds(imported + source) is expected


def test_no_other_file_compares_kinds_of_sensors() -> None:
    rooms = ("core", "widgets", "riglens", "app")
    files = [path for room in rooms for path in sorted((REPOSITORY / room).rglob("*.py"))]
    found = [str(one.relative_to(REPOSITORY)) for one in files if compares_kinds(one.read_text("utf-8"))]
    assert [name for name in found if not name.startswith(tuple(MAY_NAME_KINDS))] == []
    assert [place for place in MAY_NAME_KINDS if not any(name.startswith(place) for name in found)] == []


# ---------------------------------------------------------------- the report


def test_a_report_shows_it_beside_the_others(tmp_path: Path) -> None:
    path = tmp_path / "boxes.csv"
    rows = (
        "seq,frame,cls,x,y,z,length,width,height,yaw",
        "s,0,car,6,0,0.8,4,2,1.6,0",
        "s,1,bicycle,3,-4,0.9,2,0.6,1.7,0",
        "s,2,pedestrian,2,5,0.9,0.6,0.6,1.8,0",
    )
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    scene = SceneOptions(boxes=path, voxel_m=0.5, roi_m=(20.0, 20.0, 4.0))
    rig = rig_with(TOP, EYE, probe(rpy_deg=(0.0, 20.0, 0.0)))
    plan = ReportPlan((rig,), scene, ScoreOptions(), draws=1, seed=0)
    document = document_of(plan, report_of(plan, lambda share, stage: None))
    page = report_page(document)
    assert "By probes" in page and "pedestrian end on, probes" in page and "40 × 40" in page
    places = re.findall(r'data-from="([^"]+)"', page)
    assert "evaluation/rigs/0/classes/car/figures/probe" in places
    assert any(re.fullmatch(r"rigs/0/range/rigs/0/rows/\d+/probe/first_below_m", place) for place in places)
    assert "1 LiDAR, 1 camera, 1 probe" in page and "probes: dotted" in page
    tones = {tuple(ray["tone"]) for ray in document.drawings[0].view["rays"]}
    assert len(tones) == 3
