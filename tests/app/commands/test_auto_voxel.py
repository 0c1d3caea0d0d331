"""`--voxel auto` picks the coarsest edge that suits the rigs, says what was tried, names it in the JSON."""

import json

import pytest

ROI = ("--roi", "8", "8", "4")
BOXES = """seq,frame,cls,x,y,z,length,width,height,yaw
s,0,car,1.5,0,0.8,4.5,1.9,1.6,0.3
s,0,bicycle,2,-2,0.9,1.8,0.6,1.7,0
s,1,car,-1,2,0.8,4.5,1.9,1.6,0
s,2,pedestrian,2,2,0.9,0.6,0.6,1.8,0
"""
DENSE = """riglens: 1
name: dense
sensors:
  - {name: C, kind: camera, position: [-3.9, 0, 2], hfov_deg: 90, image: [1600, 900], cast: [1600, 900]}
"""
SPARSE = """riglens: 1
name: sparse
sensors:
  - {name: L, kind: lidar, position: [0, 0, 2], elevations_deg: {from: -40, to: 0, count: 8},
     azimuths_deg: {from: -180, to: 180, count: 90}}
"""


@pytest.fixture
def near(tmp_path):
    """A few boxes near the car."""
    path = tmp_path / "near.csv"
    path.write_text(BOXES, encoding="utf-8")
    return path


@pytest.fixture
def rigs(tmp_path):
    """A camera with rays closer than the finest voxels, and a LiDAR with gaps between its beams."""
    for name, text in (("dense", DENSE), ("sparse", SPARSE)):
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    return {name: tmp_path / f"{name}.yaml" for name in ("dense", "sparse")}


def document(result):
    assert result.code == 0, result.err
    return json.loads(result.out)


def test_it_picks_what_one_could_have_typed_and_scores_the_same(riglens, near, rigs):
    through = ("--body", "ignored")  # the outline of the car would ask for the finest edge
    found = riglens(
        "evaluate", rigs["dense"], "--boxes", near, *ROI, *through, "--voxel", "auto", "--json", "-"
    )
    auto = document(found)
    picked = auto["grid"]["voxel_m"]
    assert 0.05 < picked <= 0.4
    assert f"picked δ {picked:g} m" in found.err.replace("auto: ", "auto picked ")
    typed = document(
        riglens("evaluate", rigs["dense"], "--boxes", near, *ROI, *through, "--voxel", picked, "--json", "-")
    )
    for one in (auto, typed):
        one["rigs"][0].pop("elapsed_ms")
        one["targets"]["rigs"][0].pop("elapsed_ms")
    assert auto == typed


def test_a_rig_with_gaps_between_its_rays_needs_the_finest_edge_unless_more_is_tolerated(riglens, near, rigs):
    def picked(*more):
        run = ("evaluate", rigs["sparse"], "--boxes", near, *ROI, "--voxel", "auto", *more, "--json", "-")
        return document(riglens(*run))["grid"]["voxel_m"]

    assert picked() == 0.05
    assert picked("--voxel-tolerance", "100") == 0.4


def test_what_was_tried_stands_on_standard_error_and_standard_output_stays_clean(riglens, near, rigs):
    result = riglens(
        "evaluate",
        *rigs.values(),
        "--boxes",
        near,
        *ROI,
        "--voxel",
        "auto",
        "--voxel-tolerance",
        "2",
        "--json",
        "-",
    )
    document(result)
    for edge in ("0.05", "0.1", "0.2", "0.4"):
        assert f"δ {edge}" in result.err
    for part in ("voxel auto:", "seen differs by at most", "reference of the others", "→"):
        assert part in result.err


def test_edges_that_do_not_divide_the_region_are_named(riglens, near, rigs):
    result = riglens(
        "evaluate", rigs["dense"], "--boxes", near, "--roi", "8.2", "8", "4", "--voxel", "auto", "--json", "-"
    )
    assert document(result)["grid"]["voxel_m"] in (0.05, 0.1, 0.2)
    assert "δ 0.4  left out: L must be a multiple of the voxel edge 0.4 m" in result.err


def test_a_picture_takes_it(riglens, near, rigs, tmp_path):
    target = tmp_path / "picture.png"
    result = riglens(
        "render",
        rigs["dense"],
        "--boxes",
        near,
        *ROI,
        "--voxel",
        "auto",
        "--size",
        "200x150",
        "--out",
        target,
    )
    assert result.code == 0, result.err
    assert target.exists()
    assert "voxel auto: δ" in result.err


def test_a_stored_pog_holds_one_grid_and_refuses_it(riglens, near, rigs, tmp_path):
    pog = tmp_path / "near.npz"
    assert riglens("data", "build", near, "--out", pog, *ROI, "--voxel", "0.5").code == 0
    line = riglens("evaluate", rigs["dense"], "--pog", pog, "--voxel", "auto").refused()
    assert "near.npz holds one grid, of 0.5 m" in line


@pytest.mark.parametrize(
    ("options", "hint"),
    [
        (
            ("--voxel", "auto", "--voxel-tolerance", "-1"),
            "--voxel-tolerance must be between 0 and 100 percentage points (got -1)",
        ),
        (("--voxel", "auto", "--voxel-tolerance", "nan"), "(got nan)"),
        (
            ("--voxel-tolerance", "2"),
            "--voxel-tolerance belongs to automatic voxels: choose auto for --voxel",
        ),
        (("--voxel", "automatic"), "must be an edge in metres, or auto (got automatic)"),
        (("--voxel", "auto", "--roi", "8.03", "8", "4"), "8.03"),
    ],
)
def test_wrong_options_are_refused_in_one_line(riglens, near, rigs, options, hint):
    assert hint in riglens("evaluate", rigs["dense"], "--boxes", near, *options).refused()


def test_where_no_rig_is_scored_an_edge_in_metres_is_wanted(riglens, near, tmp_path):
    line = riglens("data", "build", near, "--out", tmp_path / "near.npz", "--voxel", "auto").refused()
    assert "edge in metres" in line
