"""A study of detection in a process of its own: it is the command line's, so window and terminal agree."""

from __future__ import annotations

import queue
import re
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from riglens.app.evaluation.options import SceneOptions
from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.metric.scores import Body
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import dumps
from riglens.core.scene.boxes import Progress

CHART, PAIRS = "detection.png", "detection-pairs.png"
_RUN = "import sys; from riglens.app.commands import main; sys.exit(main(sys.argv[1:]))"
_DONE = re.compile(r"^note: (done: .*) \((\d+) of (\d+)\)$")
_WAIT_S = 0.2


@dataclass(frozen=True)
class DetectionJob:
    """Which rigs are compared, in which traffic, how long, and the folder for results and for what is done so far."""

    rigs: tuple[Rig, ...]
    scene: SceneOptions
    body: Body | None
    folder: Path
    quick: bool = True
    workers: int = 1

    def words(self) -> list[str]:
        """The words of the command; write the rigs where it finds them."""
        scene = self.scene
        if scene.pog is not None:
            raise InputError("a stored POG holds no road users: choose box data in the Scene panel")
        words = ["study", "detection", *(str(path) for path in self._rig_files())]
        words += ["--out", str(self.folder), "--workers", str(self.workers)]
        words += [] if self.body is None else ["--body", self.body]
        words += ["--quick"] if self.quick else []
        words += [] if scene.boxes is None else ["--boxes", str(scene.boxes)]
        words += [] if scene.frames is None else ["--frames", str(scene.frames)]
        words += [] if scene.origin_m is None else ["--origin", *map(str, scene.origin_m)]
        words += ["--ground", "auto"] if scene.find_ground else []
        return words + [word for name in scene.classes for word in ("--classes", name)]

    def _rig_files(self) -> list[Path]:
        folder = self.folder / "rigs"
        folder.mkdir(parents=True, exist_ok=True)
        files = []
        for number, rig in enumerate(self.rigs, 1):
            files.append(folder / f"{number}.yaml")
            with atomic_write(files[-1], "w") as stream:
                stream.write(dumps(rig))
        return files


def study(job: DetectionJob, progress: Progress, hear: Callable[[str], None], run: str = _RUN) -> Path:
    """Run a study to its end and return its folder; `hear` is told of each piece that is done.

    `progress` may raise to cancel: the process ends, and what it has done is kept. Raise InputError with the line that
    the command gives. `run` is the program that is given the words.
    """
    command = [sys.executable, "-c", run, *job.words()]
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        encoding="utf-8", errors="replace",
    ) as process:  # fmt: skip
        assert process.stderr is not None
        try:
            last = _follow(process.stderr, progress, hear)
        except BaseException:
            process.terminate()  # at any moment: pieces appear whole or not at all
            raise
    if process.returncode != 0:
        raise InputError(last.removeprefix("riglens: ") or "the study ended without a word")
    return job.folder


def _follow(stream: IO[str], progress: Progress, hear: Callable[[str], None]) -> str:
    """Pass on what the process says until it ends; its last line."""
    lines: queue.Queue[str | None] = queue.Queue()
    threading.Thread(target=_read, args=(stream, lines), daemon=True).start()
    share, last = 0.0, ""
    while True:
        progress(share)
        try:
            line = lines.get(timeout=_WAIT_S)
        except queue.Empty:
            continue
        if line is None:
            return last
        last = line or last
        found = _DONE.match(line)
        if found is not None:
            share = int(found[2]) / int(found[3])
            hear(found[1])


def _read(stream: IO[str], lines: queue.Queue[str | None]) -> None:
    for line in stream:
        lines.put(line.strip())
    lines.put(None)
