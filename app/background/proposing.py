"""Propose rigs in a separate process of low priority, which keeps its tables and serves requests between its steps.

Requests for gains are served in the midst of a search; a newer search replaces the one under way.
"""

from __future__ import annotations

import io
import pickle
import queue
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any, Literal

import psutil
from PySide6.QtCore import QObject, Signal

from riglens.app.background.own_process import OwnProcess
from riglens.core.errors import Cancelled, InputError
from riglens.core.optimise.objectives import objective_named
from riglens.core.rig.model import Rig
from riglens.evaluation.names import label_of
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.search_options import SearchOptions

if TYPE_CHECKING:  # loads the compiler
    from numpy.typing import NDArray

    from riglens.core.optimise.problem import Problem
    from riglens.core.optimise.results import OptimiseResult, Progress
    from riglens.core.optimise.skin import SkinGains
    from riglens.core.targets.traffic import Traffic

WORK = "riglens.app.background.proposing:main"
NICE = 10
"""Niceness of the process, so that edits in the window take precedence."""
IMPROVED_WITHIN_M = 0.5
"""Greatest distance of a better mount from where the sensor is."""
SearchWork = Literal["add", "improve", "skin"]


@dataclass(frozen=True)
class ProposalRequest:
    """A search: "add" sensors, "improve" the sensor called `sensor`, or only find the gains of the "skin"."""

    number: int
    work: SearchWork
    rig: Rig
    scene: SceneOptions
    options: SearchOptions = SearchOptions()
    sensor: str = ""


@dataclass(frozen=True)
class GainsRequest:
    """Request for the gains at every spot, given the LiDARs of a rig."""

    rig: Rig


Command = Literal["pause", "go on", "stop"]
Message = ProposalRequest | GainsRequest | Command


@dataclass(frozen=True)
class SearchProgress:
    """Progress of the search `number` after `elapsed_s`: the best rig so far, its value and its bound; once all but the
    guard is done, the result with the checks so far."""

    number: int
    elapsed_s: float
    stage: str
    share: float
    best: Rig | None
    value: float | None
    bound: float | None
    result: OptimiseResult | None


@dataclass(frozen=True)
class SearchEnd:
    """End of the search `number`: with a result unless it was stopped or failed, and one line if it failed."""

    number: int
    result: OptimiseResult | None = None
    problem: str = ""


@dataclass(frozen=True)
class Spots:
    """Spots on the skin of the search `number`: points (m, 3), metres."""

    number: int
    points_m: NDArray[Any]


@dataclass(frozen=True)
class Gains:
    """Best gain of an addition at each spot of the search `number`, (m,), given a rig."""

    number: int
    rig: Rig
    gains: NDArray[Any]


Answer = SearchProgress | SearchEnd | Spots | Gains


# ---------------------------------------------------------------------- in the window
class Proposer(QObject):
    """Owner of the process, which starts with the first request. Every method is called by the interface thread."""

    answered = Signal(object)
    """An Answer."""
    failed = Signal(str)
    """The process ended by itself; why, in one line."""

    def __init__(self, parent: QObject | None = None, work: str = WORK) -> None:
        super().__init__(parent)
        self._work = work
        self._process: OwnProcess | None = None

    def send(self, message: Message) -> None:
        """Send a message, to a new process if there is none."""
        if self._process is None or not self._process.is_alive:
            self.end()
            self._process = OwnProcess(self._work)
            threading.Thread(target=self._read, args=(self._process,), daemon=True).start()
        with suppress(OSError):  # the reader says why it ended
            self._process.pipe.send(message)

    def end(self) -> None:
        """End the process at once; what it kept is lost."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()  # its reader ends with it, and emits nothing any more

    def _read(self, process: OwnProcess) -> None:
        line = ""
        with suppress(RuntimeError):  # Qt's: the window is gone
            try:
                while True:
                    answer = process.receive(answer_of)
                    if self._process is process:
                        self.answered.emit(answer)
            except InputError as error:
                line = str(error)
            except (EOFError, OSError):
                line = str(process.lost("the search for rigs"))
            if self._process is process:
                self.failed.emit(line)


def answer_of(content: bytes) -> Answer:
    """Return an answer of the process; what stays there is None."""
    answer: Answer = _Unpickler(io.BytesIO(content)).load()
    return answer


class _Unpickler(pickle.Unpickler):
    """Reader of the answers of the program's own process, in which objects that stay there are None."""

    def persistent_load(self, pid: object) -> None:
        return None


# ---------------------------------------------------------------------- in the process
def main(pipe: Connection) -> None:
    """Serve messages until the window has gone."""
    psutil.Process().nice(getattr(psutil, "BELOW_NORMAL_PRIORITY_CLASS", NICE))
    inbox: queue.SimpleQueue[Message | None] = queue.SimpleQueue()

    def read() -> None:
        """Take messages at once, so that the window never waits for a step of the search."""
        with suppress(EOFError, OSError):
            while True:
                inbox.put(pipe.recv())
        inbox.put(None)

    threading.Thread(target=read, daemon=True).start()
    server = Server(inbox, pipe.send_bytes)
    while server.serve_one():
        pass


class Server:
    """One search at a time, and the tables that it has made."""

    def __init__(self, inbox: queue.SimpleQueue[Message | None], send: Callable[[bytes], object]) -> None:
        self._inbox, self._send = inbox, send
        self._next: deque[Message | None] = deque()
        self._is_paused = self._is_stopped = False
        self._traffic: tuple[SceneOptions, Traffic] | None = None
        self._skin: tuple[int, SkinGains] | None = None
        self._paused_s = 0.0

    def serve_one(self) -> bool:
        """Serve one message; return False at the end of all."""
        message = self._next.popleft() if self._next else self._inbox.get()
        if isinstance(message, ProposalRequest):
            self._search(message)
        elif isinstance(message, GainsRequest):
            self._emit_gains(message)
        return message is not None

    # ------------------------------------------------------------------ searches
    def _search(self, request: ProposalRequest) -> None:
        self._is_stopped, self._paused_s = False, 0.0
        if request.work != "improve":
            self._skin = None
        try:
            result = self._run(request)
        except Cancelled:
            self._tell(SearchEnd(request.number))
        except InputError as error:
            self._tell(SearchEnd(request.number, problem=error.text(label_of)))
        else:
            self._tell(SearchEnd(request.number, result))

    def _run(self, request: ProposalRequest) -> OptimiseResult | None:
        from riglens.core.optimise.run import optimise, skin_gains

        problem, begun_s = self._problem(request), time.monotonic()

        def tell(step: Progress) -> None:
            if step.skin is not None:
                self._show_skin(request, step.skin)
            elapsed_s = time.monotonic() - begun_s - self._paused_s
            parts = step.stage, step.share, step.best, step.value, step.bound, step.result
            self._tell(SearchProgress(request.number, elapsed_s, *parts))

        if request.work == "skin":
            self._show_skin(request, skin_gains(problem, None, tell, self._is_stale))
            return None
        return optimise(problem, None, tell, self._is_stale)

    def _problem(self, request: ProposalRequest) -> Problem:
        from riglens.core.optimise.additions import Move
        from riglens.core.optimise.problem import Problem
        from riglens.evaluation.scenario import load_scenario

        traffic, options = self._traffic_of(request.scene), request.options
        if request.work == "improve":
            return Problem(request.rig, traffic, moves=(Move(request.sensor, IMPROVED_WITHIN_M),))
        needs_voxels = objective_named(options.objective).figure.needs == "voxels"
        voxels = load_scenario(request.scene).field if needs_voxels else None
        return options.problem(request.rig, traffic, voxels=voxels)

    def _traffic_of(self, scene: SceneOptions) -> Traffic:
        from riglens.core.targets.traffic import WITHIN_M
        from riglens.evaluation.traffic import load_traffic

        if self._traffic is None or self._traffic[0] != scene:
            self._traffic = scene, load_traffic(scene, WITHIN_M)
        return self._traffic[1]

    # ------------------------------------------------------------------ gains
    def _show_skin(self, request: ProposalRequest, skin: SkinGains) -> None:
        """Emit the spots of a search for additions once, with their gains for its rig."""
        if self._skin is None and request.work != "improve":  # of a move there are no spots for more sensors
            self._skin = request.number, skin
            self._tell(Spots(request.number, skin.points_m))
            self._emit_gains(GainsRequest(request.rig))

    def _emit_gains(self, request: GainsRequest) -> None:
        if self._skin is not None:
            number, skin = self._skin
            self._tell(Gains(number, request.rig, skin.by_spot(skin.gains(request.rig))))

    # ------------------------------------------------------------------ messages
    def _is_stale(self) -> bool:
        """Serve what has come in meanwhile, wait while paused, and return whether the search is to end."""
        begun_s = time.monotonic()
        while self._is_paused or not self._inbox.empty():
            message = self._inbox.get()
            if message in ("pause", "go on"):
                self._is_paused = message == "pause"
            elif isinstance(message, GainsRequest):
                self._emit_gains(message)
            else:
                self._is_paused, self._is_stopped = False, True
                if message != "stop":
                    self._next.append(message)
        self._paused_s += time.monotonic() - begun_s
        return self._is_stopped

    def _tell(self, answer: Answer) -> None:
        content = io.BytesIO()
        _Pickler(content).dump(answer)
        with suppress(OSError):  # the window has gone
            self._send(content.getvalue())


class _Pickler(pickle.Pickler):
    """Leaves traffic, tables and meshes, which the window has, where they are."""

    def persistent_id(self, obj: object) -> str | None:
        from riglens.core.optimise.skin import SkinGains
        from riglens.core.rig.body_mesh import BodyMesh
        from riglens.core.targets.traffic import Traffic

        return "kept" if isinstance(obj, Traffic | SkinGains | BodyMesh) else None
