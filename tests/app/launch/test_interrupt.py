"""Ctrl-C is heard by a command, ends the window at once while it starts, and in order when it is open."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import pytest
from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from riglens.app import commands
from riglens.app.launch.interrupt import AGAIN_S, LOST_S, insistent_interrupt, quit_on_interrupt
from riglens.core.files import atomic_write
from tests.waiting import TIMEOUT_MS, TIMEOUT_S, poll

# ---------------------------------------------------------------- commands


@dataclass
class HandTimer:
    """A timer that is over when a test says so."""

    seconds: float
    function: Callable[[], None]
    daemon: bool = False
    is_running: bool = False

    def start(self) -> None:
        self.is_running = True

    def cancel(self) -> None:
        self.is_running = False


class Timers(list[HandTimer]):
    """Everything that was timed, in order."""

    def __call__(self, seconds: float, function: Callable[[], None]) -> HandTimer:
        self.append(HandTimer(seconds, function))
        return self[-1]


def test_an_interruption_that_somebody_swallows_comes_again():
    before, swallowed, timers = signal.getsignal(signal.SIGINT), [], Timers()
    with pytest.raises(KeyboardInterrupt), insistent_interrupt(timers):
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt as lost:
            swallowed.append(lost)
        assert [timer.is_running for timer in timers] == [True]
        timers[0].function()
        time.sleep(TIMEOUT_S)  # until the signal is there
    assert len(swallowed) == 1
    assert signal.getsignal(signal.SIGINT) is before
    assert not any(timer.is_running for timer in timers)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_that_is_heard_comes_once(number):
    before, timers = signal.getsignal(number), Timers()
    with pytest.raises(KeyboardInterrupt), insistent_interrupt(timers):
        signal.raise_signal(number)
    assert signal.getsignal(number) is before
    assert [timer.is_running for timer in timers] == [False]


def test_sigterm_in_the_middle_of_a_file_leaves_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt), insistent_interrupt(), atomic_write(tmp_path / "x") as stream:
        stream.write(b"half")
        signal.raise_signal(signal.SIGTERM)
    assert not list(tmp_path.iterdir())


def test_a_failure_after_a_swallowed_interruption_is_an_interruption():
    with pytest.raises(KeyboardInterrupt), insistent_interrupt():
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise RuntimeError("half done") from None


def test_an_interruption_that_python_drops_comes_again_soon_and_is_not_reported(capsys):
    class Dying:
        def __init__(self, die: Callable[[], object]) -> None:
            self.die = die

        def __del__(self) -> None:
            self.die()

    before, timers = sys.unraisablehook, Timers()
    with insistent_interrupt(timers):
        Dying(lambda: signal.raise_signal(signal.SIGINT))
        assert [timer.seconds for timer in timers if timer.is_running] == [AGAIN_S, LOST_S]
        said = capsys.readouterr().err
    assert said == "" and sys.unraisablehook is before


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_while_the_commands_are_loaded_is_one_line(number, monkeypatch, capsys):
    class Interrupted:
        def find_spec(self, name: str, *_: object) -> None:
            if name == "riglens.app.commands.running":
                signal.raise_signal(number)

    before = {one: signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)}
    signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # a shell in the background starts programs without
    monkeypatch.setattr(sys, "meta_path", [Interrupted(), *sys.meta_path])
    monkeypatch.delitem(sys.modules, "riglens.app.commands.running", raising=False)
    monkeypatch.delattr(commands, "running", raising=False)
    try:
        assert commands.main([]) == 130
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
    assert capsys.readouterr() == ("", "riglens: interrupted; no file was changed\n")


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_after_the_work_keeps_the_exit_code(name):
    run = (
        "import os, signal, sys; from riglens.app.commands import main; sys.argv[1:] = ['list', 'rigs'];"
        f"code = main(); os.kill(os.getpid(), signal.{name}); raise SystemExit(code)"
    )
    done = subprocess.run([sys.executable, "-c", run], capture_output=True, timeout=TIMEOUT_S)
    assert (done.returncode, done.stderr) == (0, b"") and b"W+T" in done.stdout


# ---------------------------------------------------------------- the window


class Keeper(QWidget):
    """A window that notes whether it was told to close, and does so if it likes."""

    told = Signal()

    def __init__(self, is_willing: bool) -> None:
        super().__init__()
        self.is_willing = is_willing
        self.times_told = 0

    def closeEvent(self, event: QCloseEvent) -> None:
        self.times_told += 1
        event.setAccepted(self.is_willing)
        self.told.emit()


def press_ctrl_c() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def application_with(window: QWidget) -> QApplication:
    app = QApplication.instance()
    assert isinstance(app, QApplication)
    window.show()
    QTimer.singleShot(TIMEOUT_MS, window, lambda: app.exit(1))  # rather than wait for ever
    return app


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_while_qt_is_loaded_ends_the_process_at_once(riglens_process, xvfb, tmp_path, number):
    process = riglens_process(env={"XDG_CONFIG_HOME": str(tmp_path), "XDG_STATE_HOME": str(tmp_path)})
    poll(lambda: has_loaded(process.pid, "libQt6Core"))
    process.send_signal(number)
    output, errors = process.communicate(timeout=TIMEOUT_S)
    assert (process.returncode, output, errors) == (130, "", "riglens: interrupted\n")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_closes_the_windows_from_qts_loop_and_not_in_the_middle_of_a_drawing(
    qtbot: QtBot, number: signal.Signals
) -> None:
    window = Keeper(is_willing=True)
    qtbot.addWidget(window)
    app = application_with(window)
    told_while_drawing: list[int] = []

    def draw() -> None:
        os.kill(os.getpid(), number)
        told_while_drawing.append(window.times_told)

    with quit_on_interrupt(app) as interrupt:
        QTimer.singleShot(0, draw)
        app.exec()
    assert told_while_drawing == [0]
    assert window.times_told == 1 and not window.isVisible()
    assert interrupt.code == 130


def test_a_window_that_stays_open_calls_ctrl_c_off(qtbot: QtBot) -> None:
    window = Keeper(is_willing=False)
    qtbot.addWidget(window)
    app = application_with(window)
    codes: list[int] = []

    def look() -> None:
        codes.append(interrupt.code)
        if len(codes) == 2:
            app.exit()
        else:
            press_ctrl_c()  # no second press of the same: the first was answered

    with quit_on_interrupt(app) as interrupt:
        window.told.connect(look, Qt.ConnectionType.QueuedConnection)
        QTimer.singleShot(0, press_ctrl_c)
        app.exec()
    assert codes == [0, 0] and window.times_told == 2 and window.isVisible()
    window.is_willing = True


def test_a_second_ctrl_c_before_the_first_was_heeded_ends_the_process() -> None:
    script = (
        "import os, signal\n"
        "from PySide6.QtWidgets import QApplication\n"
        "from riglens.app.launch.interrupt import quit_on_interrupt\n"
        "with quit_on_interrupt(QApplication(['riglens'])):\n"
        "    for _ in range(2):\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n"
        "    print('still there')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, encoding="utf-8", timeout=TIMEOUT_S, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "riglens: interrupted\n")


def test_a_thread_that_goes_on_does_not_keep_the_process() -> None:
    script = (
        "import threading\n"
        "from riglens.app.launch.interrupt import Grace\n"
        "Grace().start(3)\n"
        "threading.Event().wait(300)\n"  # as a join of a thread that compiles
    )
    done = subprocess.run([sys.executable, "-c", script], timeout=TIMEOUT_S, check=False)
    assert done.returncode == 3


def has_loaded(pid: int, library: str) -> bool:
    """Whether the process has mapped a shared library."""
    with open(f"/proc/{pid}/maps", encoding="utf-8") as maps:
        return library in maps.read()
