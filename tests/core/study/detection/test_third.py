"""The third study is the one that was registered: its rigs, protocols and figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from riglens.core.rig.model import Camera, Rig
from riglens.core.study.detection.making import sweeps_of
from riglens.core.study.detection.pieces import Study, views_of
from riglens.core.study.detection.protocol import entrants, train_frames
from riglens.core.study.detection.third import (
    MEETING,
    PARTS,
    fused_lidars,
    rigs_of_part,
    with_cameras,
)
from tests.core.study.detection.small import NOWHERE, PROTOCOL, digest, traffic

REGISTERED = Path(__file__).resolve().parents[4] / "docs" / "data" / "detection3-registered.md"


def test_rigs_and_protocols_are_those_that_were_registered() -> None:
    text = REGISTERED.read_text(encoding="utf-8")
    assert f"`{digest(PARTS, rigs_of_part)}`" in text
    assert all(f"- {one.name}\n" in text for one in rigs_of_part("lidars"))


def test_dense_rigs_have_more_rays_than_any_before() -> None:
    rays = [one.rays for one in entrants(rigs_of_part("lidars"))]
    assert max(rays[:8]) <= 115_200 and min(rays[8:]) > 200_000 and 900_000 < max(rays) <= 1_000_000


def test_sets_of_cameras_differ_and_have_no_lidar() -> None:
    rigs = entrants(rigs_of_part("cameras"), PARTS["cameras"].kinds)
    assert len({one.key for one in rigs}) == len(rigs) == 8 and not any(one.rays for one in rigs)
    split, how = Study(rigs, PROTOCOL, traffic(), NOWHERE).split, replace(PARTS["cameras"], train_frames=6)
    frames = {tuple(train_frames(one, split, how)) for one in rigs}
    assert len(frames) > 1  # each set of cameras draws its own


def test_a_rig_meets_cameras_with_its_own_lidars() -> None:
    lidars = fused_lidars()[0]
    both = [with_cameras(lidars, name) for name in MEETING]
    assert [len(one.enabled_cameras()) for one in both] == [3, 6, 6]
    assert all(one.enabled_lidars() == lidars.enabled_lidars() for one in both)


def test_pictures_of_a_rig_hold_the_objects_of_its_frames() -> None:
    eye = Camera(name="CAM", position=(0.0, 0.0, 2.0), hfov_deg=110.0, image=(320, 128), cast=(160, 64))
    back = eye.replace(name="BACK", rpy_deg=(0.0, 0.0, 180.0))
    how = replace(PROTOCOL, detector="pictures")
    study = Study(entrants([Rig(name="two", sensors=(eye, back))], how.kinds), how, traffic(), NOWHERE)
    assert study.trained_on == study.compared  # no references: they are LiDARs
    views = views_of(sweeps_of(study, study.compared[0]), "test")
    frames = len(study.split.test)
    assert views.pixels.shape == (frames, 2, 64, 160, 3) and len(views.mark_starts) == 2 * frames + 1
    assert views.frame.tolist() == study.split.test.tolist()
    assert np.diff(views.object_starts).tolist() == [3] * frames
    for frame in range(frames):
        objects = slice(*views.object_starts[frame : frame + 2])
        away = np.hypot(*(views.centre_m[objects]).T)
        for camera in range(2):
            marks = views.marks(frame, camera)
            assert np.abs(marks.distance_m[:, None] - away).min(axis=1).max(initial=0.0) < 1e-4
            assert set(marks.cls) <= set(views.cls[objects])
    assert len(views.mark_cls) > frames
