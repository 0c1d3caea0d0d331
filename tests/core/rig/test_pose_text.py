"""A pose that was copied as text can be pasted again, in every form that engineers exchange."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.pose_text import POSE_FORMATS, PoseFormat, parse_pose, pose_text

METRES = st.floats(-100.0, 100.0)
DEGREES = st.floats(-180.0, 180.0)
POSES = st.builds(Pose, st.tuples(METRES, METRES, METRES), st.tuples(DEGREES, DEGREES, DEGREES))
HERE = Pose((1.0, -2.0, 1.5), (0.0, 0.0, 90.0))


@given(POSES, st.sampled_from(["yaml", "numbers"]))
def test_yaml_and_numbers_give_back_the_same_bits(pose: Pose, form: PoseFormat) -> None:
    assert parse_pose(pose_text(pose, form)) == pose


@given(POSES, st.sampled_from(list(POSE_FORMATS)))
def test_every_form_gives_back_the_same_place_and_turn(pose: Pose, form: PoseFormat) -> None:
    read = parse_pose(pose_text(pose, form))
    np.testing.assert_allclose(read.vehicle_SE3_sensor(), pose.vehicle_SE3_sensor(), atol=1e-9)


@pytest.mark.parametrize(
    "text",
    [
        "1 -2 1.5 0 0 90",
        "1, -2, 1.5,  0, 0, 90",
        "[1, -2, 1.5] [0 0 9e1]",
        "position: [1, -2, 1.5]\nrpy_deg: [0, 0, 90]",
        "    position: [1.0, -2.0, 1.5]\n    rpy_deg: [0.0, 0.0, 90.0]\n",
        "  - name: roof\n    kind: lidar\n    position: [1, -2, 1.5]\n    rpy_deg: [0, 0, 90]\n",
        "{position: [1, -2, 1.5], rpy_deg: [0, 0, 90]}",
        "position: [1, -2, 1.5]\nquaternion_xyzw: [0, 0, 0.7071, 0.7071]",
        "1 -2 1.5 0 0 0.70711 0.70711",
        "0 -1 0 1\n1 0 0 -2\n0 0 1 1.5\n0 0 0 1",
        "[[0, -1, 0, 1], [1, 0, 0, -2], [0, 0, 1, 1.5]]",
    ],
)
def test_poses_are_read_as_people_and_programs_write_them(text: str) -> None:
    np.testing.assert_allclose(parse_pose(text).vehicle_SE3_sensor(), HERE.vehicle_SE3_sensor(), atol=1e-4)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "roof",
        "1 2 3",
        "1 2 3 4 5",
        "x 1 2 3 4 5 6",
        "1 2 3 0 0 0 2",
        "1 2 3 0 0 0 0",
        "1e999 2 3 0 0 0",
        "2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1",
        "-1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1",
        "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 5 1",
        "position: [1, 2]\nrpy_deg: [0, 0, 0]",
        "position: [1, 2, .nan]\nrpy_deg: [0, 0, 0]",
        "position: here",
        "rpy_deg: [0, 0, 0]",
        "position: !!python/object:os.system [1, 2, 3]",
        "position: [1, 2, 3",
        "1 " * 3000,
    ],
)
def test_what_is_no_pose_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_pose(text)
    assert "\n" not in str(refused.value)
