"""A report made in a process of its own: it is the command line's, so window and terminal agree."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from riglens.app.evaluation.options import SceneOptions
from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import dumps
from riglens.core.scene.boxes import Progress

_RUN = "import sys; from riglens.app.commands import main; sys.exit(main(sys.argv[1:]))"
_PRINT = (
    "import sys; from pathlib import Path; from riglens.app.commands.report_job import print_page; "
    "print_page(Path(sys.argv[1]), Path(sys.argv[2]))"
)
_DRAW = _PRINT.replace("print_page", "draw_pages")
_WAIT_S = 0.2


@dataclass(frozen=True)
class ReportJob:
    """Which rigs a report is about, in which traffic, with which settings of the score, and the file to write."""

    rigs: tuple[Rig, ...]
    scene: SceneOptions
    settings: MetricSettings
    out: Path

    def words(self, rigs: list[Path]) -> list[str]:
        """The words of the command, for rigs in these files."""
        scene, settings = self.scene, self.settings
        words = ["report", *map(str, rigs), "--out", str(self.out)]
        words += [] if settings.body is None else ["--body", settings.body]
        words += ["--method", settings.method, "--reading", settings.reading]
        words += ["--lambda", repr(settings.camera_weight)]
        for name, value in (("--boxes", scene.boxes), ("--pog", scene.pog), ("--frames", scene.frames)):
            words += [] if value is None else [name, str(value)]
        if scene.pog is None:
            words += [] if scene.voxel_m is None else ["--voxel", repr(scene.voxel_m)]
            words += [] if scene.roi_m is None else ["--roi", *map(repr, scene.roi_m)]
        words += [] if scene.origin_m is None else ["--origin", *map(repr, scene.origin_m)]
        words += ["--ground", "auto"] if scene.find_ground else []
        return words + [word for name in scene.classes for word in ("--classes", name)]


def make_report(job: ReportJob, progress: Progress, run: str = _RUN) -> Path:
    """Make a report and return its file. `progress`, of which no share is known, may raise to cancel: the process ends.

    Raise InputError with the line that the command gives. `run` is the program that is given the words.
    """
    with tempfile.TemporaryDirectory(prefix="riglens-report-") as folder:
        files = [Path(folder) / f"{number}.yaml" for number in range(1, len(job.rigs) + 1)]
        for path, rig in zip(files, job.rigs, strict=True):
            with atomic_write(path, "w") as stream:
                stream.write(dumps(rig))
        _run([sys.executable, "-c", run, *job.words(files)], progress)
    return job.out


def print_report(page: Path, out: Path, progress: Progress, run: str = _PRINT) -> Path:
    """Write the PDF of a page that was made before and return its file; as `make_report` in all else."""
    _run([sys.executable, "-c", run, str(page), str(out)], progress)
    return out


def draw_report(page: Path, progress: Progress, run: str = _DRAW) -> list[Path]:
    """Draw a page that was made before as it is printed, and return the pictures, in a folder beside it."""
    folder = page.parent / "pages"
    folder.mkdir()
    _run([sys.executable, "-c", run, str(page), str(folder)], progress)
    return sorted(folder.glob("*.png"))


def _run(command: list[str], progress: Progress) -> None:
    """Run a program to its end; InputError with its last line when it is not well."""
    with tempfile.TemporaryFile() as said:
        with subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=said
        ) as process:
            try:
                _wait(process, progress)
            except BaseException:
                process.terminate()  # at any moment: the page appears whole or not at all
                raise
        if process.returncode != 0:
            said.seek(0)
            lines = said.read().decode("utf-8", errors="replace").split("\n")
            last = next((line for line in reversed(lines) if line.strip()), "")
            raise InputError(last.removeprefix("riglens: ") or "the report ended without a word")


def _wait(process: subprocess.Popen[bytes], progress: Progress) -> None:
    while True:
        progress(0.0)
        try:
            process.wait(_WAIT_S)
        except subprocess.TimeoutExpired:
            continue
        return
