"""The command line `riglens`: what can be said, and what becomes of errors, Ctrl-C and closed pipes.

Only light modules are imported here, so that `riglens --help` answers at once and a command that draws
nothing never loads Qt or VTK; each command imports its own job when it runs.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import App, CycloptsError, Group, Parameter, Token, UnusedCliTokensError

from app.options import DEFAULT_RIG, DEFAULT_TOLERANCE_PP, AutoVoxel, SceneOptions, ScoreOptions, Triple
from app.system_libraries import MissingLibraries
from core.errors import InputError

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
SCENE = Group("Scene: boxes and grid", sort_key=10)
SCORE = Group("Score", sort_key=20)
BUILD = Group("Build", sort_key=30)


def _whole_number(_: Any, tokens: Sequence[Token]) -> int:
    """A whole number as written; 1.5 is not rounded."""
    found = tokens[0].value
    if not found.strip().lstrip("+-").isdecimal():
        raise ValueError(f"found {found}, accepted is a whole number")
    return int(found)


def _edge_or_auto(_: Any, tokens: Sequence[Token]) -> float | str:
    """A voxel edge in metres, or the word auto."""
    found = tokens[0].value
    if found == "auto":
        return found
    try:
        return float(found)
    except ValueError:
        raise ValueError(f"found {found}, accepted is an edge in metres, or auto") from None


Whole = Annotated[int | None, Parameter(converter=_whole_number, metavar="N")]


def _scene(name: str, metavar: str, converter: Callable[..., Any] | None = None) -> Parameter:
    return Parameter(
        name=name,
        group=SCENE,
        metavar=metavar,
        show_default=False,
        show_choices=converter is None,
        converter=converter,
    )


@Parameter(name="*")
@dataclass(frozen=True)
class Boxes:
    """How boxes are read, the same for every command that reads boxes."""

    origin: Annotated[Triple | None, _scene("--origin", "X Y Z")] = None
    """Where the origin of the data set lies in the vehicle frame, metres (nuScenes ego: -1.35 0 0)."""
    frames: Annotated[Whole, _scene("--frames", "N")] = None
    """Number of frames of the data set, where frames without boxes have no row."""
    classes: Annotated[tuple[str, ...], _scene("--classes", "NAME=CLASS")] = ()
    """Count boxes called NAME as car, bicycle or pedestrian, or ignore them; may be given many times."""
    ground: Annotated[Literal["auto"] | None, _scene("--ground", "auto")] = None
    """With auto, estimate the ground by the bottoms of near boxes and put it at z = 0; see `riglens data`."""


@Parameter(name="*")
@dataclass(frozen=True)
class Reading:
    """How boxes are read and cut into voxels."""

    how: Boxes = Boxes()
    voxel: Annotated[float | Literal["auto"] | None, _scene("--voxel", "M|auto", _edge_or_auto)] = None
    """Edge of a voxel in metres (0.1). With auto, where rigs are scored: the coarsest that suits them."""
    roi: Annotated[Triple | None, _scene("--roi", "L W H")] = None
    """Region of interest in metres: x in [-L/2, L/2), y in [-W/2, W/2), z in [0, H) (60 40 4)."""

    def options(
        self, boxes: Path | None, pog: Path | None = None, tolerance_pp: float | None = None
    ) -> SceneOptions:
        """The same with the data it is about, checked."""
        auto, voxel_m = None, self.voxel
        if voxel_m == "auto":
            auto, voxel_m = AutoVoxel(DEFAULT_TOLERANCE_PP if tolerance_pp is None else tolerance_pp), None
        elif tolerance_pp is not None:
            raise InputError(
                f"--tolerance {tolerance_pp:g} belongs to --voxel auto; add that, or leave it out"
            )
        how, ground = self.how, self.how.ground == "auto"
        return SceneOptions(boxes, how.origin, how.frames, how.classes, voxel_m, self.roi, pog, auto, ground)


@Parameter(name="*")
@dataclass(frozen=True)
class Scene:
    """The scene that rigs are scored on."""

    boxes: Annotated[Path | None, _scene("--boxes", "PATH")] = None
    """Box data set: table, nuScenes, Argoverse 2, KITTI or CARLA folder. Without it: the bundled scenario."""
    reading: Reading = Reading()
    pog: Annotated[Path | None, _scene("--pog", "FILE")] = None
    """Use a stored POG (made by `riglens pog`) instead of boxes."""
    tolerance: Annotated[float | None, _scene("--tolerance", "PP")] = None
    """What --voxel auto may change: percentage points of the entropy that is seen (1)."""

    def options(self) -> SceneOptions:
        """The same, checked."""
        return self.reading.options(self.boxes, self.pog, self.tolerance)


@Parameter(name="*")
@dataclass(frozen=True)
class Score:
    """Options about the metric."""

    method: Annotated[Literal["exact", "bresenham"], Parameter(group=SCORE, metavar="NAME")] = "exact"
    """How rays visit voxels."""
    reading: Annotated[Literal["covered", "residual", "hits"], Parameter(group=SCORE, metavar="NAME")] = (
        "covered"
    )
    """How S-MIG is read; see docs/metric.md."""
    camera_weight: Annotated[float, Parameter(name="--lambda", group=SCORE, metavar="X")] = 0.1
    """Weight of the cameras in S-MS."""
    threads: Annotated[Whole, Parameter(group=SCORE)] = None
    """Threads to use (all cores). The scores do not depend on it."""

    def options(self) -> ScoreOptions:
        """The same, checked."""
        return ScoreOptions(self.method, self.reading, self.camera_weight, self.threads)


@Parameter(name="*")
@dataclass(frozen=True)
class Libraries:
    """Sensor models beside those that ship with the program."""

    library: Annotated[tuple[Path, ...], Parameter(name="--library", metavar="FILE", show_default=False)] = ()
    """A file with sensor models of your own, for rigs that name them; may be given many times."""

    def use(self) -> None:
        """Have rigs find the models of these files."""
        if self.library:
            from core.rig.library import use_libraries

            use_libraries(self.library)


def _version() -> str:
    try:
        return version("riglens")
    except PackageNotFoundError:
        return "not installed as a package"


app = App(
    name="riglens",
    help="Place LiDARs and cameras on a car and score how well they see traffic (S-MS). "
    "RIG is a rig file or the name of a preset (W+T); see `riglens presets`.",
    help_format="plaintext",
    usage="Usage: riglens [RIG] [OPTIONS]\n       riglens COMMAND [OPTIONS] [ARGS]\n",
    version=_version,
    default_parameter=Parameter(negative=()),
    suppress_keyboard_interrupt=False,
)
study = App(name="study", help="Repeat studies of the paper.", help_format="plaintext")
app.command(study)

Rig = Annotated[str, Parameter(name="RIG")]
Out = Annotated[Path, Parameter(metavar="FILE")]


def _check_json(target: str | None) -> None:
    if target is not None and target.startswith("-") and target != "-":
        raise InputError(f"--json: found '{target}', accepted is a file name, or - for standard output")


@app.default
def window(
    rig: Rig = DEFAULT_RIG,
    /,
    *,
    scene: Scene = Scene(),
    score: Score = Score(),
    libraries: Libraries = Libraries(),
) -> int:
    """Open the window on RIG (W+T). Without a display: the scores, and a picture, YAML and JSON in out/."""
    libraries.use()
    options, metric = scene.options(), score.options()
    from app.main import start

    return start(rig, options, metric)


@app.command(sort_key=1)
def evaluate(
    *rigs: Annotated[str, Parameter(name="RIG", required=True)],
    scene: Scene = Scene(),
    libraries: Libraries = Libraries(),
    score: Score = Score(),
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> None:
    """Score one or more rigs.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    json
        Also write the scores as JSON to a file; with - to standard output, instead of the table.
    """
    _check_json(json)
    libraries.use()
    options, metric = scene.options(), score.options()
    from app import jobs

    jobs.evaluate(rigs, options, metric, json)


@app.command(sort_key=2)
def pog(
    *boxes: Annotated[Path, Parameter(name="BOXES", required=True)],
    out: Out,
    reading: Reading = Reading(),
    workers: Annotated[Whole, Parameter(group=BUILD)] = None,
    dask: Annotated[str | None, Parameter(group=BUILD, metavar="ADDRESS")] = None,
) -> None:
    """Build the POG of one or more box data sets together and store it for --pog.

    A build of many logs or tables works on several of them at once. When it is interrupted, the same command goes
    on where it was.

    Parameters
    ----------
    boxes
        Box data sets: tables, nuScenes, Argoverse 2, KITTI or CARLA folders.
    out
        Where to store it (.npz). Finished parts are kept beside it, in FILE.parts, until all is done.
    workers
        Processes that build parts at the same time (as many as cores, parts and memory allow).
    dask
        Build the parts on the Dask cluster whose scheduler listens there, such as tcp://10.0.0.1:8786.
    """
    options = reading.options(boxes[0])
    from app import pog_job

    pog_job.build_pog_file(options, boxes, out, workers, dask)


@app.command(sort_key=3)
def data(
    *boxes: Annotated[Path, Parameter(name="BOXES", required=True)],
    how: Boxes = Boxes(),
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> None:
    """Say what box data hold: classes, directions, distances, sizes, the ground, and what is not mapped.

    Parameters
    ----------
    boxes
        Box data sets: tables, nuScenes, Argoverse 2, KITTI or CARLA folders.
    json
        Also write the figures as JSON to a file; with - to standard output, instead of the tables.
    """
    _check_json(json)
    options = Reading(how).options(boxes[0])
    from app import data_job

    data_job.describe(options, boxes, json)


@app.command(sort_key=4)
def render(
    rig: Rig,
    /,
    *,
    out: Out,
    view: Annotated[Literal["iso", "top", "front", "left", "rear"], Parameter(metavar="NAME")] = "iso",
    size: Annotated[str, Parameter(metavar="WxH")] = "1280x800",
    scale: Annotated[int, Parameter(converter=_whole_number, metavar="K")] = 1,
    cls: Annotated[
        Literal["car", "bicycle", "pedestrian"], Parameter(name="--class", metavar="NAME")
    ] = "car",
    heatmap: Annotated[
        Literal["probability", "entropy", "seen", "unseen", "sensors", "change", "off"],
        Parameter(metavar="NAME"),
    ] = "seen",
    baseline: Annotated[str | None, Parameter(metavar="RIG")] = None,
    slice: Annotated[tuple[float, float] | None, Parameter(metavar="FROM TO")] = None,
    threshold: Annotated[float | None, Parameter(metavar="SHARE")] = None,
    log: bool = False,
    opacity: Annotated[float | None, Parameter(metavar="SHARE")] = None,
    transparent: bool = False,
    legend: Annotated[bool, Parameter(negative="--no-legend")] = True,
    title: bool = False,
    scores: bool = False,
    theme: Annotated[Literal["dark", "light"], Parameter(metavar="NAME")] = "dark",
    scene: Scene = Scene(),
    libraries: Libraries = Libraries(),
) -> None:
    """Draw a rig, its rays and the heatmap of a class into a PNG file, without a display.

    Parameters
    ----------
    rig
        Rig file or preset name.
    out
        The picture (.png).
    view
        Where to look from.
    size
        Size of the picture in pixels.
    scale
        Draw K times as many pixels along each side, with lines and letters as large.
    cls
        Class of the heatmap.
    heatmap
        What the heatmap shows: probability of being occupied, entropy, the entropy that the rig sees or does not
        see, by how many sensors a place is seen, or the change against --baseline.
    baseline
        The rig that --heatmap change starts from.
    slice
        Draw only cells of the heatmap between two heights, metres.
    threshold
        Leave out cells in the lowest part of the colour scale, 0 to 1 (0.02).
    log
        Logarithmic colour scale, three powers of ten long.
    opacity
        Opacity of the highest values, 0 to 1 (0.5).
    transparent
        No background.
    legend
        The colour bar.
    title
        Name of the rig and what it was scored on, in the upper corner.
    scores
        The table of scores, in the lower corner.
    theme
        Dark or light background.
    """
    libraries.use()
    options = scene.options()
    from app import render as drawing

    drawing.render(
        rig,
        options,
        drawing.Picture(
            out, view, drawing.parse_size(size), scale, cls, heatmap, transparent, legend, title, scores, theme,
            threshold, log, opacity, slice, baseline,
        ),
    )  # fmt: skip


@app.command(sort_key=5)
def presets(
    name: Annotated[str | None, Parameter(name="NAME")] = None,
    /,
    *,
    out: Annotated[Path | None, Parameter(metavar="RIG.yaml")] = None,
) -> None:
    """List the built-in rigs, or print one as rig YAML, or write it to a file.

    Parameters
    ----------
    name
        One preset; without it all are listed.
    out
        Write the preset NAME to this file.
    """
    if name is None and out is not None:
        raise InputError("--out: name the preset to write as well: riglens presets NAME --out RIG.yaml")
    from app import jobs

    jobs.presets(name, out)


@app.command(sort_key=5)
def convert(
    source: Annotated[str, Parameter(name="IN")],
    out: Annotated[Path, Parameter(name="OUT")],
    /,
    *,
    from_: Annotated[str | None, Parameter(name="--from", metavar="FORMAT")] = None,
    to: Annotated[str | None, Parameter(name="--to", metavar="FORMAT")] = None,
    vehicle: Annotated[str | None, Parameter(metavar="RIG")] = None,
    rear_axle_x: Annotated[float | None, Parameter(metavar="M")] = None,
    origin: Annotated[Triple | None, Parameter(metavar="X Y Z")] = None,
    token: Annotated[str | None, Parameter(metavar="TEXT")] = None,
) -> None:
    """Convert a rig between formats, and say what was converted, approximated or left out.

    Formats: riglens, nuscenes, autoware, urdf, carla, carla-toml, driveworks both ways; pandaset, kalibr, kitti
    read only; osi written only.

    Parameters
    ----------
    source
        Rig file, preset name, or a file or folder of another program.
    out
        File to write; a folder for nuscenes and autoware.
    from_
        Format of IN, where it cannot be told by the file.
    to
        Format of OUT, where its ending does not say it.
    vehicle
        Take the vehicle of this rig file, where IN does not know its car.
    rear_axle_x
        Where the rear axle is, in metres from the body centre (-1.35).
    origin
        Where the origin of IN lies in the vehicle frame, in metres.
    token
        Which rig of several: a token of nuScenes, the id of a CARLA vehicle.
    """
    from app.convert import Conversion
    from app.convert import convert as run

    run(Conversion(source, out, from_, to, vehicle, rear_axle_x, origin, token))


@app.command(sort_key=7)
def library(
    name: Annotated[str | None, Parameter(name="NAME")] = None,
    /,
    *,
    kind: Annotated[Literal["lidar", "camera"] | None, Parameter(metavar="KIND")] = None,
    json: bool = False,
    libraries: Libraries = Libraries(),
) -> None:
    """List the sensor models, or show one with its beams or lens and where its figures come from.

    Parameters
    ----------
    name
        One model; without it all are listed.
    kind
        Only LiDARs or only cameras.
    json
        Print JSON, with every figure of every model listed.
    """
    if name is not None and kind is not None:
        raise InputError(f"--kind {kind} chooses what is listed; leave it out to show the model {name}")
    libraries.use()
    from app import library_listing

    library_listing.show(name, kind, json)


@study.command
def table1(
    *,
    scene: Scene = Scene(),
    score: Score = Score(),
    csv: Annotated[Path | None, Parameter(metavar="FILE")] = None,
) -> None:
    """The paper's Table I: its eight rigs scored here, beside the published figures, with their orders.

    Parameters
    ----------
    csv
        Also write the table as CSV.
    """
    options, metric = scene.options(), score.options()
    from app import jobs

    jobs.table1(options, metric, csv)


@study.command
def accuracy(
    rig: Rig = DEFAULT_RIG,
    /,
    *,
    scene: Scene = Scene(),
    libraries: Libraries = Libraries(),
    camera_weight: Annotated[float, Parameter(name="--lambda", group=SCORE, metavar="X")] = 0.1,
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    out: Annotated[Path, Parameter(metavar="DIR")] = Path("out"),
    quick: bool = False,
) -> None:
    """Time against error of ways to score a rig: methods, voxel edges, ray lattices; chart and CSV.

    Parameters
    ----------
    rig
        Rig file or preset name.
    camera_weight
        Weight of the cameras in S-MS.
    threads
        Threads to use (all cores).
    out
        Folder for accuracy.png, accuracy.svg and accuracy.csv.
    quick
        One run of each instead of five, and fewer settings: a look, not a measurement.
    """
    libraries.use()
    options, metric = scene.options(), ScoreOptions(camera_weight=camera_weight, threads=threads)
    from app import study_accuracy

    study_accuracy.study(rig, options, metric, out, quick)


@study.command
def stability(
    *,
    scene: Scene = Scene(),
    camera_weight: Annotated[float, Parameter(name="--lambda", group=SCORE, metavar="X")] = 0.1,
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    edits: Whole = None,
    out: Annotated[Path, Parameter(metavar="DIR")] = Path("out"),
    quick: bool = False,
) -> None:
    """Where methods of traversal break, and how far the order of the paper's rigs can be relied on.

    Parameters
    ----------
    camera_weight
        Weight of the cameras in S-MS.
    threads
        Threads to use (all cores).
    edits
        Number of random edits that are compared with an evaluation from scratch (1000).
    out
        Folder for stability.html, stability-methods.csv and stability-metric.csv.
    quick
        Smaller cases and fewer settings: a look, not a measurement.
    """
    options, metric = scene.options(), ScoreOptions(camera_weight=camera_weight, threads=threads)
    from app import study_stability

    study_stability.study(options, metric, out, quick, edits)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code. Bad input gives one line on standard error."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        tokens = sys.argv[1:] if arguments is None else list(arguments)
        code = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
        sys.stdout.flush()
    except UnusedCliTokensError as error:
        return _say(f"found {' '.join(error.unused_tokens or ())}, where no more is expected", BAD_INPUT)
    except (InputError, CycloptsError, MissingLibraries) as error:
        return _say(str(error), BAD_INPUT)
    except KeyboardInterrupt:
        return _say("interrupted; no file was changed", INTERRUPTED)
    except MemoryError:
        return _say("out of memory; use larger voxels, a smaller ROI or fewer rays", FAILED)
    except BrokenPipeError:
        _forget_stdout()
        return DONE
    except OSError as error:  # the system's fault, not the program's: a full disk, a device that is gone
        _forget_stdout()
        place = f"{error.filename}: " if error.filename else ""
        return _say(f"{place}{error.strerror or error}", FAILED)
    except SystemExit:  # this is how rich says that nobody reads its output any more
        return DONE
    return code if isinstance(code, int) else DONE


def _say(message: str, code: int) -> int:
    """Print one line on standard error and pass the exit code on."""
    print(f"riglens: {' '.join(message.split())}", file=sys.stderr)
    return code


def _forget_stdout() -> None:
    """Standard output is closed or full: keep Python from trying, and complaining, once more at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
