"""What is done in a study: frames, rigs, and what is refused in one line. No PyTorch is needed for it."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.rig.presets import preset
from riglens.core.study.detection.making import sweeps_of
from riglens.core.study.detection.pieces import Job, Pieces, Study, samples_of
from riglens.core.study.detection.protocol import Protocol, entrants, references, split, train_frames
from riglens.core.study.detection.published import CAMERA_PROTOCOL, camera_rigs, equal_rays, published_rigs
from riglens.core.study.detection.published import PROTOCOL as PUBLISHED
from tests.core.review.scenes import BOX_FILE, box_mesh
from tests.core.study.detection.small import NOWHERE, PROTOCOL, rig, traffic


def study(*rigs: object, protocol: Protocol = PROTOCOL) -> Study:
    return Study(entrants(rigs), protocol, traffic(), NOWHERE)  # type: ignore[arg-type]


def test_whole_sequences_are_for_training_or_for_the_test() -> None:
    found, labels = split(traffic().data, PROTOCOL), traffic().data.labels
    assert labels is not None
    train, test = (set(labels.sequence[frames].tolist()) for frames in (found.train, found.test))
    assert not train & test and len(train) == 5 and len(test) == 3
    assert [found.sequences[number] for number in found.sequence] == [
        labels.names[number] for number in labels.sequence[found.test]
    ]
    assert len(found.test) == 10 and len(np.unique(found.test)) == 10


@pytest.mark.parametrize(("sequences", "each"), [(1, 3), (1, 200), (3, 50), (4, 4)])
def test_too_few_frames_or_sequences_are_refused_in_one_line(sequences: int, each: int) -> None:
    with pytest.raises(InputError) as told:
        split(traffic(sequences, each).data, PROTOCOL)
    text = str(told.value)
    assert f"(got {sequences * each} in {sequences})" in text and "\n" not in text


def test_data_without_named_sequences_are_refused() -> None:
    with pytest.raises(InputError, match="named sequences"):
        split(replace(traffic().data, labels=None), PROTOCOL)


def test_a_rig_of_cameras_alone_is_refused_and_cameras_of_others_left_out() -> None:
    with pytest.raises(InputError, match="rig 'Wide' must have an enabled LiDAR") as told:
        entrants([preset("Wide")])
    assert "\n" not in str(told.value)
    (one,) = entrants([preset("W+T")])
    assert [sensor.kind for sensor in one.rig.sensors] == ["lidar"] * 4
    assert one.key == entrants([preset("Trapezoid")])[0].key
    assert one.rays == 4 * 16 * 360


def test_rigs_of_one_name_are_told_apart() -> None:
    found = entrants([rig("a"), rig("a", beams=4), rig("a", beams=6)])
    assert [one.name for one in found] == ["a", "a (2)", "a (3)"]


def test_every_rig_trains_on_a_draw_of_its_own_of_equal_size() -> None:
    one, other = entrants([rig("a"), rig("b", beams=4)])
    of = split(traffic().data, PROTOCOL)
    frames = [train_frames(entrant, of, PROTOCOL) for entrant in (one, other)]
    assert [len(part) for part in frames] == [12, 12]
    assert all(set(part.tolist()) <= set(of.train.tolist()) for part in frames)
    assert frames[0].tolist() != frames[1].tolist()
    assert (train_frames(one, of, PROTOCOL) == frames[0]).all()
    everything = train_frames(one, of, replace(PROTOCOL, train_frames=10**6))
    assert everything.tolist() == sorted(of.train.tolist())


def test_references_train_along_once_and_only_in_a_shared_net() -> None:
    shared = study(preset("Trapezoid"), rig("a"))
    assert len(shared.trained_on) == 2 + 3  # Trapezoid is a reference itself
    assert len(references()) == 4
    own = study(rig("a"), rig("b", 4), protocol=replace(PROTOCOL, mode="per-rig"))
    assert [one.name for one in own.trained_on] == ["a", "b"]
    assert [(net.seed, net.trains[0].name) for net in own.nets] == [(0, "a"), (0, "b"), (1, "a"), (1, "b")]


def test_names_of_pieces_change_with_what_decides_them_and_with_nothing_else() -> None:
    one = study(rig("a"), rig("b", 4))
    renamed = study(rig("c"), rig("b", 4))
    longer = study(rig("a"), rig("b", 4), protocol=replace(PROTOCOL, epochs=3))
    (a, *_), (c, *_), (d, *_) = one.compared, renamed.compared, longer.compared
    assert one.sweeps_key(a) == renamed.sweeps_key(c) == longer.sweeps_key(d)
    assert one.net_key(one.nets[0]) == renamed.net_key(renamed.nets[0]) != longer.net_key(longer.nets[0])
    assert one.net_key(one.nets[0]) != one.net_key(one.nets[1])
    cuda = replace(one, machine=replace(NOWHERE, device="cuda"))
    assert one.net_key(one.nets[0]) != cuda.net_key(cuda.nets[0])
    denser = study(rig("a", beams=9), rig("b", 4))
    assert one.sweeps_key(a) != denser.sweeps_key(denser.compared[0])


def test_quick_and_per_rig() -> None:
    assert (Protocol().quick().seeds, Protocol().quick().epochs) == (1, 4)
    assert Protocol().per_rig().train_frames == 1500 and Protocol().per_rig().mode == "per-rig"
    with pytest.raises(InputError, match=r"^seeds must be"):
        replace(Protocol(), seeds=0)


def test_the_published_rigs_are_those_that_were_registered() -> None:
    rigs = entrants(published_rigs())
    names = [one.name for one in rigs]
    assert len(names) == len(set(names)) == len({one.key for one in rigs}) == 30
    drawn = {"hesai-pandar90", "ouster-os0-32", "velodyne-vlp-16", "ouster-os2-128", "robosense-rs-lidar-32"}
    assert drawn < set(names)
    assert len(equal_rays([one.rays for one in rigs])) == 17
    assert {one.key for one in references()} < {one.key for one in rigs}
    assert (PUBLISHED.seeds, PUBLISHED.epochs) == (5, 4)
    every = "".join(one.key for one in rigs)  # whatever the library says since
    assert hashlib.sha256(every.encode()).hexdigest()[:16] == "ff7f0f10a7c0a29e"
    assert (PUBLISHED.train_frames, PUBLISHED.test_frames) == (200, 500)


def test_with_cameras_rigs_of_the_same_lidars_have_the_same_frames_and_other_sweeps() -> None:
    rigs = entrants([preset("W+T"), preset("N+T"), preset("Trapezoid")], "lidars and cameras")
    assert [len(one.rig.enabled_cameras()) for one in rigs] == [6, 6, 0] and len(
        {one.key for one in rigs}
    ) == 3
    asked = Study(rigs, replace(PROTOCOL, cameras="usual"), traffic(), NOWHERE)
    frames = [train_frames(one, asked.split, PROTOCOL).tolist() for one in rigs]
    assert frames[0] == frames[1] == frames[2]
    assert len(asked.trained_on) == 3 + 3  # W+T is a reference itself
    assert all(one.rig.enabled_cameras() for one in references("lidars and cameras"))
    poor = replace(asked, protocol=replace(PROTOCOL, cameras="poor"))
    without = replace(asked, protocol=PROTOCOL)
    assert len({one.sweeps_key(rigs[2]) for one in (asked, poor, without)}) == 3
    assert "painting" not in PROTOCOL.as_dict()  # pieces of studies without cameras keep their names


def test_a_body_of_a_file_stops_rays_and_decides_the_sweeps() -> None:
    low = rig("low", height_m=1.6).replace(vehicle=BOX_FILE)
    protocol = replace(PROTOCOL, mode="per-rig", simulation=replace(PROTOCOL.simulation, body="blocks"))
    unread, boxed, taller = (
        Study(entrants([low.with_body_mesh(mesh)]), protocol, traffic(), NOWHERE)
        for mesh in (None, box_mesh(), box_mesh(height_m=1.55))
    )
    assert len({one.compared[0].key for one in (unread, boxed, taller)}) == 3
    with pytest.raises(InputError, match=r"the mesh 'box\.stl' has not been read"):
        sweeps_of(unread, unread.compared[0])
    through = replace(unread, protocol=PROTOCOL)
    figures = [
        len(samples_of(sweeps_of(asked, asked.compared[0]), "test").cell) for asked in (boxed, through)
    ]
    assert 0 < figures[0] < figures[1]


def test_the_rigs_with_cameras_are_those_that_were_registered() -> None:
    rigs = entrants(camera_rigs(), "lidars and cameras")
    groups = [one.name for one in rigs[:4]]
    assert groups == ["Center", "Pyramid", "Line", "Trapezoid"]
    assert [one.name for one in rigs[4:]] == [f"{camera}+{name[0]}" for name in groups for camera in "WN"]
    how = CAMERA_PROTOCOL
    assert (how.seeds, how.epochs, how.train_frames, how.test_frames) == (3, 4, 150, 300)
    assert how.cameras == "usual" and how.simulation.body == "ignored"


def test_a_piece_is_called_by_what_it_makes() -> None:
    asked = study(rig("a"), rig("b", 4))
    net, first = asked.nets[0], asked.compared[0]
    assert [Job(*of).title for of in ((None, first), (net, first), (net, None, 2))] == [
        "sweeps of a", "a, seed 1", "net of seed 1, pass 2",
    ]  # fmt: skip


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04 cut off", b"\x93NUMPY\x01\x00v\x00{}"])
def test_a_damaged_piece_counts_for_nothing_and_is_one_line_where_it_is_needed(
    tmp_path: Path, content: bytes
) -> None:
    asked = study(rig("a"), rig("b", 4))
    pieces, (net, *_) = Pieces(asked, tmp_path), asked.nets
    key = Job(net, asked.compared[0]).key(asked)
    (tmp_path / f"{key}.piece").write_bytes(content)
    assert not pieces.has_found(net, asked.compared[0])
    with pytest.raises(ChildProcessError, match="an unexpected result"):
        pieces.store.keep(key, content)
    with pytest.raises(InputError, match="a, seed 1: missing or damaged; run the same command again"):
        pieces.of(Job(net, asked.compared[0]))
