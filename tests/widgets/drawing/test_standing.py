"""While something is dragged only what moves is drawn: the picture is the one that drawing everything gives."""

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.rig.model import Camera, Rig
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.drawing.stage import Stage, render_window
from riglens.widgets.heatmap.scale import HeatLook
from riglens.widgets.theme import LIGHT
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.ground_map import GroundMap, GroundStep
from riglens.widgets.viewport.scene_state import SceneState
from tests.widgets.viewport.test_still import LIDAR, wall

OTHER = LIDAR.replace(name="other", position=(0.9, 0.6, 1.6))
STEPS = (GroundStep("low", "#20c040", 0.6), GroundStep("high", "#c02040", 0.6))
CAMERA = OrbitCamera((0.0, 0.0, 0.7), 10.0, -70.0, 25.0)
STATE = SceneState(
    rig=Rig(sensors=(LIDAR, OTHER)), selected=LIDAR.name, heatmap=wall(4.0), camera=CAMERA, gizmo_mode="move"
)


class HandClock:
    """A clock that is turned by hand."""

    def __init__(self):
        self.now_s = 0.0

    def __call__(self):
        return self.now_s


@pytest.fixture
def clock():
    return HandClock()


@pytest.fixture
def scene(plotter, clock):
    scene = DrawnScene(plotter, clock=clock)
    scene.show(STATE)
    scene.set_quick(True)
    return scene


@pytest.fixture
def kept(monkeypatch, clock):
    """When what stands still was drawn and kept, which takes a twentieth of a second."""
    times, keep, swap = [], Stage.keep, Stage.swap_begun

    def slow(then):
        def noted(stage):
            clock.now_s += 0.05
            times.append(clock.now_s)
            then(stage)

        return noted

    monkeypatch.setattr(Stage, "keep", slow(keep))
    monkeypatch.setattr(Stage, "swap_begun", slow(swap))
    return times


def shot(plotter):
    return np.asarray(plotter.screenshot(None, return_img=True))[:, :, :3].astype(int)


def step(plotter, scene):
    """A frame of a drag."""
    scene.prepare()
    scene.draw_moving()
    return shot(plotter)


def frame(plotter, scene):
    """A frame of a drag after another heatmap has been drawn, if one is due, and the same drawn in one go."""
    moving = step(plotter, scene)
    if scene.haze_is_due:
        for _ in scene.draw_haze():
            pass
        moving = step(plotter, scene)
    scene.prepare()
    render_window(plotter).Render()
    return moving, shot(plotter)


def look_alike(moving, whole):
    """Whether pictures differ at most where rays that stand still pass before the small body that moves."""
    return (np.abs(moving - whole).max(axis=2) > 0).mean() < 1e-3


def moved(state, name, x_m):
    sensor = state.rig.sensor(name)
    return replace(
        state, rig=state.rig.with_sensor(name, sensor.replace(position=(x_m, *sensor.position[1:])))
    )


def test_every_frame_of_a_drag_is_the_one_that_drawing_everything_gives(plotter, scene, kept):
    state, last = STATE, None
    for step in range(5):
        state = moved(state, LIDAR.name, 0.1 * step)
        scene.show(state)
        moving, whole = frame(plotter, scene)
        assert look_alike(moving, whole)
        assert last is None or not np.array_equal(moving, last), "the sensor is somewhere else"
        last = moving
    assert len(kept) == 1, "what stands still was drawn once"


def test_a_new_heatmap_is_seen_in_the_next_frame_and_drawn_once(plotter, scene, kept, clock):
    for step in range(3):
        scene.show(moved(STATE, LIDAR.name, 0.1 * step))
        before, _ = frame(plotter, scene)
    scene.show(replace(scene.state, heatmap=wall(3.0)))
    clock.now_s += 1.0
    for _ in range(2):
        moving, whole = frame(plotter, scene)
        assert look_alike(moving, whole)
    assert not np.array_equal(moving, before)
    assert len(kept) == 2


def test_frames_go_on_over_the_picture_before_until_the_new_heatmap_is_whole(plotter, scene, kept, clock):
    for number in range(3):
        scene.show(moved(STATE, LIDAR.name, 0.1 * number))
        frame(plotter, scene)
    old = scene.state
    scene.show(replace(old, heatmap=wall(3.0)))
    clock.now_s += 1.0
    parts = scene.draw_haze()
    for number in (3, 4):
        next(parts)
        scene.show(moved(scene.state, LIDAR.name, 0.1 * number))
        between = step(plotter, scene)
    assert len(kept) == 1 and scene.haze_is_due
    assert list(parts) == [] and len(kept) == 2 and not scene.haze_is_due
    after = step(plotter, scene)
    assert look_alike(after, frame(plotter, scene)[1])
    scene.set_quick(False)
    scene.set_quick(True)
    scene.show(replace(scene.state, heatmap=old.heatmap))
    assert look_alike(between, frame(plotter, scene)[1]) and not look_alike(between, after)


@pytest.mark.parametrize(
    "change",
    [
        lambda scene: scene.show(moved(scene.state, OTHER.name, -0.8)),
        lambda scene: scene.show(replace(scene.state, camera=replace(CAMERA, azimuth_deg=-40.0))),
        lambda scene: scene.set_quick(False),
    ],
    ids=["another sensor", "camera", "at rest"],
)
def test_a_heatmap_half_drawn_is_given_up_when_what_stands_still_changes(plotter, scene, kept, clock, change):
    for number in range(3):
        scene.show(moved(STATE, LIDAR.name, 0.1 * number))
        frame(plotter, scene)
    scene.show(replace(scene.state, heatmap=wall(3.0)))
    clock.now_s += 1.0
    parts = scene.draw_haze()
    next(parts)
    change(scene)
    step(plotter, scene)
    before = len(kept)
    with pytest.raises(StopIteration) as end:
        next(parts)
    assert end.value.value is False and len(kept) == before
    scene.set_quick(True)
    clock.now_s += 1.0
    for _ in range(2):
        assert look_alike(*frame(plotter, scene))


def test_heatmaps_that_follow_closely_wait_and_the_last_one_is_drawn(plotter, scene, kept, clock):
    for step in range(3):
        scene.show(moved(STATE, LIDAR.name, 0.1 * step))
        before, _ = frame(plotter, scene)
    for metres in (3.5, 3.2, 3.0):
        scene.show(replace(scene.state, heatmap=wall(metres)))
        moving, _ = frame(plotter, scene)
        assert look_alike(moving, before)
    assert len(kept) == 1
    clock.now_s += 1.0
    moving, whole = frame(plotter, scene)
    assert look_alike(moving, whole) and not look_alike(moving, before)


@pytest.mark.parametrize(
    "change",
    [
        lambda state: moved(state, OTHER.name, -0.8),
        lambda state: replace(state, hidden=frozenset({OTHER.name})),
        lambda state: replace(state, camera=replace(CAMERA, azimuth_deg=-40.0)),
        lambda state: replace(state, palette=LIGHT),
        lambda state: replace(state, heatmap=None),
        lambda state: replace(state, ray_look=replace(state.ray_look, fill="frusta")),
    ],
    ids=["another sensor", "hidden", "camera", "palette", "no heatmap", "filled"],
)
def test_whatever_changes_amid_a_drag_is_seen_in_the_next_frame(plotter, scene, clock, change):
    for step in range(3):
        scene.show(moved(STATE, LIDAR.name, 0.1 * step))
        before, _ = frame(plotter, scene)
    scene.show(change(scene.state))
    clock.now_s += 1.0
    for _ in range(3):
        moving, whole = frame(plotter, scene)
        assert look_alike(moving, whole)
    assert not np.array_equal(moving, before)


def test_another_size_forgets_what_was_kept(plotter, scene):
    for step in range(3):
        scene.show(moved(STATE, LIDAR.name, 0.1 * step))
        frame(plotter, scene)
    render_window(plotter).SetSize(200, 150)
    for _ in range(3):
        moving, whole = frame(plotter, scene)
        assert moving.shape == (150, 200, 3)
        assert look_alike(moving, whole)


def test_a_turning_view_keeps_nothing(plotter, scene, kept):
    for step in range(4):
        scene.show(replace(STATE, camera=replace(CAMERA, azimuth_deg=-70.0 + step)))
        moving, whole = frame(plotter, scene)
        assert look_alike(moving, whole)
    assert not kept


def test_the_next_drag_begins_anew(plotter, scene):
    for step in range(3):
        scene.show(moved(STATE, LIDAR.name, 0.1 * step))
        frame(plotter, scene)
    scene.set_quick(False)
    frame_at_rest = replace(scene.state, rig=moved(scene.state, OTHER.name, -0.5).rig)
    scene.show(frame_at_rest)
    scene.set_quick(True)
    for step in range(3):
        scene.show(moved(frame_at_rest, OTHER.name, 0.1 * step))
        moving, whole = frame(plotter, scene)
        assert look_alike(moving, whole)


def test_a_heatmap_that_waits_is_not_taken_for_drawn_when_something_else_changes(plotter, scene, kept, clock):
    for step in range(3):
        scene.show(moved(STATE, LIDAR.name, 0.1 * step))
        frame(plotter, scene)
    scene.show(replace(scene.state, heatmap=wall(3.0)))
    scene.show(moved(scene.state, OTHER.name, -0.8))
    scene.prepare()
    scene.draw_moving()
    clock.now_s += 1.0
    moving, _ = frame(plotter, scene)
    scene.set_quick(False)
    scene.set_quick(True)
    assert look_alike(moving, frame(plotter, scene)[1])


def test_a_map_on_the_ground_that_changes_stays_below_the_rays(plotter, scene, clock):
    maps = [
        GroundMap((-6.0, -6.0), 0.5, np.full((24, 24), step, np.uint8), STEPS, "height in m")
        for step in (0, 1, 0, 1)
    ]
    for step, ground in enumerate(maps):
        scene.show(replace(moved(scene.state, LIDAR.name, 0.1 * step), ground_map=ground))
        clock.now_s += 1.0
        moving, whole = frame(plotter, scene)
        assert look_alike(moving, whole)


def test_the_legend_keeps_its_words_while_a_heatmap_waits(plotter, scene, kept, clock):
    for step in range(3):
        scene.show(moved(STATE, LIDAR.name, 0.1 * step))
        frame(plotter, scene)
    words = scene._words._legend.texts
    scene.show(replace(scene.state, heatmap=wall(3.0)))
    scene.prepare()
    scene.draw_moving()
    assert scene._words._legend.texts == words


def test_a_heatmap_on_the_ground_lies_over_the_footprint_that_is_dragged(plotter, scene):
    camera = Camera(name="front", position=(0.3, 0.0, 1.5), hfov_deg=90.0, cast=(64, 36))
    state = replace(
        STATE, rig=Rig(sensors=(camera, OTHER)), selected="front", heat_look=HeatLook(draped=True),
        camera=OrbitCamera((6.0, 0.0, 0.0), 20.0, -150.0, 25.0),
    )  # fmt: skip
    for step in range(3):
        state = moved(state, "front", 0.1 * step)
        scene.show(state)
        moving, whole = frame(plotter, scene)
        assert look_alike(moving, whole)


AHEAD, ASIDE = (
    Camera(name=name, position=(0.3, 0.0, 1.5), rpy_deg=(0.0, 10.0, yaw_deg), hfov_deg=90.0, cast=(64, 36))
    for name, yaw_deg in (("ahead", 0.0), ("aside", 60.0))
)
ON_GROUND = replace(
    STATE, rig=Rig(sensors=(LIDAR, AHEAD, ASIDE)), heatmap=None, camera=OrbitCamera((6.0, 0.0, 0.0), 20.0, -150.0, 25.0)
)  # fmt: skip


def test_footprints_look_the_same_while_something_moves(plotter, scene):
    alone, shots = replace(ON_GROUND, rig=Rig(sensors=(AHEAD, ASIDE)), selected=None, show_legend=False), []
    for state, is_quick in (
        (alone, True),
        (alone, False),
        (replace(alone, hidden=frozenset({"ahead", "aside"})), True),
    ):
        scene.show(state)
        scene.set_quick(is_quick)
        scene.prepare()
        render_window(plotter).Render()
        shots.append(shot(plotter))
    moving, rested, without = shots
    assert np.abs(moving - rested).mean() < 0.2 * np.abs(without - rested).mean()


def test_footprints_of_others_that_change_amid_a_drag_are_seen(plotter, scene, kept, clock):
    for step in range(3):
        clock.now_s += 1.0
        scene.show(moved(moved(ON_GROUND, LIDAR.name, 0.1 * step), "aside", 0.2 * step))
        moving, whole = frame(plotter, scene)
        assert look_alike(moving, whole)
