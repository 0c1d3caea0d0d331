"""Cameras with lens distortion on the command line: scored, and rays that the lens has not are said."""

SMALL = ("--voxel", "0.5", "--roi", "20", "20", "4")
BARREL = """\
riglens: 1
name: bent
sensors:
  - name: cam
    kind: camera
    position: [0.5, 0, 1.8]
    image: [1280, 960]
    fx: 300
    fy: 300
    cx: 640
    cy: 480
    distortion: {model: brown_conrady, k1: -0.35}
    cast: [64, 48]
"""


def test_rays_that_the_lens_has_not_are_counted_in_a_note(riglens, boxes, tmp_path):
    (tmp_path / "bent.yaml").write_text(BARREL)
    result = riglens("evaluate", tmp_path / "bent.yaml", "--boxes", boxes, *SMALL)
    assert result.code == 0
    assert "bent: cam: 2,772 of 3,072 rays lie beyond what its lens model can say" in result.err
    (tmp_path / "mild.yaml").write_text(BARREL.replace("-0.35", "-0.01"))
    assert "lens" not in riglens("evaluate", tmp_path / "mild.yaml", "--boxes", boxes, *SMALL).err


def test_the_accuracy_study_refuses_what_its_rough_methods_do_not_know(riglens, boxes, tmp_path):
    (tmp_path / "bent.yaml").write_text(BARREL)
    result = riglens("study", "accuracy", tmp_path / "bent.yaml", "--boxes", boxes, *SMALL)
    assert (result.code, result.out) == (2, "")
    assert "sensor cam has lens distortion or azimuth offsets" in result.err
