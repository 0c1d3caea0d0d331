"""Why a voxel edge was picked is said with the edge, the bound and what stopped it."""

from riglens.core.metric.scores import ClassScores, KindScore, Scores
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.voxel_choice import EdgeScores, VoxelChoice, choose
from riglens.evaluation.voxel_words import reason, tried_lines

FINE, MIDDLE, COARSE = 0.05, 0.1, 0.2


def scores(camera: float = 0.5, lidar: float = 0.2, seen: float = 0.6, s_ms: float = -1.0) -> Scores:
    one = ClassScores(
        100.0, {"camera": KindScore(-camera, camera), "lidar": KindScore(-lidar, lidar)}, seen, s_ms
    )
    return Scores(dict.fromkeys(CLASSES, one), {})


def tried(voxel_m: float, *rigs: Scores) -> EdgeScores:
    return EdgeScores(voxel_m, tuple((f"rig {i}", one) for i, one in enumerate(rigs)))


def explained() -> VoxelChoice:
    found = [tried(FINE, scores()), tried(MIDDLE, scores(lidar=0.205)), tried(COARSE, scores(lidar=0.25))]
    return choose(found, 0.01, ((0.4, "does not divide"),))


def test_the_reason_names_the_edge_the_bound_and_what_stopped_it() -> None:
    sentence = reason(explained())
    for part in ("δ 0.1 m", "1 pp", "δ 0.05 m", "at δ 0.2 m", "seen by LiDARs, car", "5.00 pp"):
        assert part in sentence


def test_the_table_has_a_line_for_every_edge_and_marks_the_picked_one() -> None:
    lines = list(tried_lines(explained()))
    assert [line.split("δ ")[1].split()[0] for line in lines] == ["0.05", "0.1", "0.2", "0.4"]
    assert [line.startswith("→") for line in lines] == [False, True, False, False]
    assert "does not divide" in lines[-1]


def test_two_rigs_that_change_places_are_named() -> None:
    found = [
        tried(FINE, scores(s_ms=-2.0), scores(s_ms=-1.0)),
        tried(COARSE, scores(s_ms=-1.0), scores(s_ms=-2.0)),
    ]
    assert "rig 0 and rig 1 change their order by S-MS for car" in reason(choose(found, 1.0))
