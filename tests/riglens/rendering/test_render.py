"""`riglens render` draws car, sensors and heatmap; `riglens` without a display does the same job."""

import io
import json
import pickle

import matplotlib.image
import numpy as np
import pytest

from riglens.app.commands import start
from riglens.core.figures.registry import leading_figures
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import load_rig
from riglens.evaluation.options import DEFAULT_RIG, SceneOptions, ScoreOptions
from riglens.widgets.viewport import still
from tests.app.conftest import SMALL_GRID
from tests.waiting import TIMEOUT_S

PNG = b"\x89PNG\r\n\x1a\n"
NO_DISPLAY = {"DISPLAY": "", "WAYLAND_DISPLAY": "", "QT_QPA_PLATFORM": ""}


def pixels(path):
    return np.round(matplotlib.image.imread(path)[..., :3] * 255).astype(int)


def heat_share(image):
    """Share of the picture, above its legend, that has the yellow of the heatmap's largest values."""
    red, green, blue = np.moveaxis(image[: len(image) * 3 // 4], 2, 0)
    return np.mean((red > 140) & (green > 140) & (red - blue > 40) & (green - blue > 40))


def test_the_picture_has_the_size_that_was_asked_for(riglens, boxes, tmp_path):
    out = tmp_path / "rig.png"
    result = riglens(
        "render", "W+T", "--boxes", boxes, *SMALL_GRID, "--out", out, "--size", "320x200", "--scale", "2"
    )
    assert result.code == 0, result.err
    assert out.read_bytes().startswith(PNG)
    assert pixels(out).shape == (400, 640, 3)
    assert "640 x 400" in result.out


def content(of):
    """Every value of what is handed over, whoever else holds it."""
    pickler = pickle.Pickler(stream := io.BytesIO())
    pickler.fast = True  # nothing is written as the same as before
    pickler.dump(of)
    return stream.getvalue()


def test_every_option_changes_what_is_drawn(riglens, boxes, tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(still, "render_still", lambda *what, **how: drawn.append(content((what, how))))

    def asked(*extra, rig="W+T"):
        options = ("--boxes", boxes, *SMALL_GRID, "--size", "320x200", "--out", tmp_path / "one.png")
        assert riglens("render", rig, *options, *extra).code == 0
        return drawn.pop()

    first = asked()
    assert first == asked()
    options = (
        "--view top", "--class pedestrian", "--heatmap off", "--heatmap sensors",
        "--heatmap change --baseline N+C", "--slice 0.5 1", "--log", "--threshold 0.5", "--opacity 0.1", "--no-legend",
        "--no-rays", "--ray-opacity 0.6", "--ray-density 4", "--fill none", "--fill frusta", "--all-rays", "--draped",
        "--title", "--scores", "--px-per-m 200 50", "--plain-traffic",
        "--scale 2", "--transparent", "--no-ground", "--theme light",
    )  # fmt: skip
    pictures = [first, asked(rig="Center"), *(asked(*option.split()) for option in options)]
    assert len(set(pictures)) == len(pictures)


def test_a_transparent_picture_has_no_background(riglens, boxes, tmp_path):
    out = tmp_path / "clear.png"
    options = (
        "--boxes",
        boxes,
        *SMALL_GRID,
        "--size",
        "320x200",
        "--out",
        out,
        "--transparent",
        "--no-legend",
    )
    assert riglens("render", "W+T", *options).code == 0
    image = matplotlib.image.imread(out)
    assert image.shape == (200, 320, 4)
    assert image[..., 3].min() == 0.0 and image[..., 3].max() == 1.0


@pytest.mark.parametrize(
    ("options", "hint"),
    [
        (("--out", "picture.jpg"), ".png"),
        (("--size", "huge"), "WIDTHxHEIGHT"),
        (("--size", "9000x9000"), "8192"),
        (("--size", "0x10"), "64"),
        (("--scale", "0"), "--scale"),
        (("--scale", "9"), "--scale"),
        (("--view", "below"), "iso"),
        (("--class", "tram"), "pedestrian"),
        (("--ray-opacity", "1.5"), "between 0 and 1"),
        (("--ray-density", "nan"), "between 0.125 and 8"),
        (("--px-per-m", "25", "50"), "falling"),
        (("--plain-traffic", "--pog", "town.npz"), "holds no objects"),
        (("--slice", "2", "1"), "FROM below TO"),
        (("--slice", "0", "inf"), "FROM below TO"),
        (("--threshold", "1.5"), "between 0 and 1"),
        (("--opacity", "nan"), "between 0 and 1"),
        (("--heatmap", "change"), "--heatmap change needs --baseline"),
        (("--baseline", "W+C"), "needs change as --heatmap"),
    ],
)
def test_a_picture_that_cannot_be_drawn_is_refused_by_option(riglens, tmp_path, monkeypatch, options, hint):
    monkeypatch.chdir(tmp_path)
    chosen = options if options[0] == "--out" else (*options, "--out", "picture.png")
    assert hint in riglens("render", "W+T", *chosen).refused()
    assert list(tmp_path.iterdir()) == []


def test_without_a_display_the_same_job_runs_in_the_terminal(riglens_process, boxes, tmp_path):
    process = riglens_process("Line", "--boxes", boxes, *SMALL_GRID, env=NO_DISPLAY, cwd=tmp_path)
    out, err = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0, err
    assert err.splitlines()[0].startswith("no display: running headless")
    assert "Line" in out
    assert "S-MS" in out
    picture = pixels(tmp_path / "out" / "screenshot.png").reshape(-1, 3)
    assert len(np.unique(picture, axis=0)) > 1000, "the car is drawn; these sensors leave no traffic unseen"
    assert load_rig(tmp_path / "out" / "rig.yaml").rig == preset("Line")
    document = json.loads((tmp_path / "out" / "scores.json").read_text(encoding="utf-8"))
    assert document["rigs"][0]["name"] == "Line"
    assert all(
        figure.title in out
        and (found := document["rigs"][0]["classes"]["car"]["figures"][figure.key])
        and (found["value"] is not None or found["reason"])
        for figure in leading_figures()
    )
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "screenshot.png",
        "rig.yaml",
        "scores.json",
    }


def test_without_a_display_and_a_rig_the_start_rig_and_that_of_the_paper_are_scored(monkeypatch, capsys):
    scored = []
    monkeypatch.setattr(start, "missing_display", lambda: "none")
    monkeypatch.setattr(start, "_score_and_draw", lambda rigs, *_: scored.append(rigs))
    assert start.start(DEFAULT_RIG, SceneOptions(), ScoreOptions()) == 0
    assert scored == [[preset("nuScenes car"), preset("W+T")]]
    assert capsys.readouterr().err.splitlines()[0] == "no display: running headless (none)"


def test_a_display_that_does_not_answer_is_no_display(riglens_process, tmp_path):
    environment = {**NO_DISPLAY, "DISPLAY": ":98765"}
    process = riglens_process("W+T", "--boxes", "no-such-boxes", env=environment, cwd=tmp_path)
    _, err = process.communicate(timeout=TIMEOUT_S)
    assert "no display: running headless (DISPLAY is :98765, but nothing answers there)" in err
    assert process.returncode == 2
    assert list(tmp_path.iterdir()) == []


def test_missing_system_libraries_are_named_with_the_command_that_installs_them(
    riglens, tmp_path, monkeypatch
):
    from riglens.rendering import system_libraries

    monkeypatch.setattr(system_libraries.ctypes, "CDLL", _fails_for_egl(system_libraries.ctypes.CDLL))
    line = riglens("render", "W+T", "--out", tmp_path / "a.png").refused()
    assert "libEGL.so.1" in line
    assert "apt-get install -y libegl1" in line


def _fails_for_egl(real):
    def load(name, *rest, **keywords):
        if name == "libEGL.so.1":
            raise OSError(name)
        return real(name, *rest, **keywords)

    return load


def test_a_box_stands_in_for_a_mesh_that_is_missing_and_an_odd_size_is_told(riglens, boxes, tmp_path):
    options = ("--boxes", boxes, *SMALL_GRID, "--size", "320x200")
    rig, picture = tmp_path / "rig.yaml", tmp_path / "rig.png"
    rig.write_text("riglens: 1\nname: mine\nvehicle: {body: car.obj}\n", encoding="utf-8")
    missing = riglens("render", rig, *options, "--out", picture)
    assert (missing.code, "replaces it" in missing.err, "car.obj: no such file" in missing.err) == (
        0,
        True,
        True,
    )
    box = pixels(picture)
    corners = [(x, y, z) for x in (0, 2000) for y in (0, 1) for z in (0, 1)]
    quads = ("1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6")
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {quad}" for quad in quads]
    (tmp_path / "car.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    giant = riglens("render", rig, *options, "--out", picture)
    assert giant.code == 0
    assert (
        "2,000.00 × 1.00 × 1.00 m; set vehicle.mesh.scale: 0.001 if the file is in millimetres" in giant.err
    )
    assert not np.array_equal(box, pixels(picture))
