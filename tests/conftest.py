"""One environment for all tests: a display of their own, an empty cache folder, no leaked threads.

Qt reads DISPLAY when the application object is made, and VTK picks its OpenGL window by it, so the virtual
display starts before any test is collected. The user's own display and cache are never touched.
"""

import gc
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

SCREEN = "1600x1000x24"
THREAD_GRACE_S = 60.0
"""How long a thread that was told to end may take on a busy computer; only a test that leaves one behind waits."""
REPOSITORY = Path(__file__).resolve().parents[1]
KERNELS = REPOSITORY / "core" / "kernels" / "__pycache__"
os.environ.setdefault("NUMBA_CACHE_DIR", str(KERNELS))
"""Kept, or every run would compile all kernels. Numba reads it when it is imported, which conftest files below may do
before pytest is configured."""
WARN_ENCODING = "PYTHONWARNDEFAULTENCODING"
"""Python reads it when it starts: it warns, and tests fail, where we open a file in the encoding of the system."""
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
"""Bytecode is kept, or each of the workers and of some hundred programs that tests start would compile all sources."""
if "PYTEST_XDIST_WORKER" in os.environ:  # workers share the processors, and more threads wait for one another
    os.environ.setdefault("NUMBA_NUM_THREADS", "2")

settings.register_profile("riglens", derandomize=True, deadline=None, print_blob=True)
settings.load_profile("riglens")


class VirtualDisplay:
    """An Xvfb server on a free display number; `name` is what DISPLAY has to be."""

    def __init__(self, screen: str = SCREEN) -> None:
        read_fd, write_fd = os.pipe()
        command = f"Xvfb -displayfd {write_fd} -screen 0 {screen} -nolisten tcp -noreset".split()
        self._server = subprocess.Popen(
            command, pass_fds=[write_fd], stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        os.close(write_fd)
        with os.fdopen(read_fd, encoding="utf-8") as answer:
            number = answer.readline().strip()
        if not number:
            raise RuntimeError(f"Xvfb ended with code {self._server.wait()} before it opened a display")
        self.name = f":{number}"

    def close(self) -> None:
        """End the server and wait for it."""
        self._server.terminate()
        self._server.wait()


def pytest_configure(config: pytest.Config) -> None:
    """Point Qt, VTK and the product's cache at things that belong to this test run."""
    if config.getoption("numprocesses", None) and not hasattr(config, "workerinput"):
        os.environ[WARN_ENCODING] = "1"
        return  # the tests run in the workers, each of which does this for itself
    os.environ.pop(WARN_ENCODING, None)  # programs that tests start would print what libraries do
    folder = tempfile.TemporaryDirectory(prefix="riglens-tests-")
    config.add_cleanup(folder.cleanup)
    os.environ["RIGLENS_CACHE_DIR"] = str(Path(folder.name) / "cache")
    os.environ["RIGLENS_CONFIG_DIR"] = str(Path(folder.name) / "settings")
    os.environ["RIGLENS_STATE_DIR"] = str(Path(folder.name) / "state")
    os.environ["XDG_CONFIG_HOME"] = str(Path(folder.name) / "config")
    if sys.platform != "linux":
        return
    os.environ["LIBGL_ALWAYS_SOFTWARE"] = "1"
    os.environ["QT_QPA_PLATFORM"] = "xcb"
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_API", "VTK_DEFAULT_OPENGL_WINDOW"):
        os.environ.pop(name, None)
    if shutil.which("Xvfb"):
        display = VirtualDisplay()
        config.add_cleanup(display.close)
        os.environ["DISPLAY"] = display.name


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Look for no garbage while tests are collected, and afterwards not among them and the modules, which stay."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown() -> Generator[None, object, object]:
    """Delete the windows that a test has closed: without a running event loop they would pile up."""
    try:
        return (yield)
    finally:
        if (qt := sys.modules.get("PySide6.QtCore")) is not None:
            qt.QCoreApplication.sendPostedEvents(None, qt.QEvent.Type.DeferredDelete.value)


@pytest.fixture(scope="session")
def xvfb() -> str:
    """Name of the virtual display of this test session, such as ":99"."""
    name = os.environ.get("DISPLAY")
    if not name:
        pytest.fail("window tests need Xvfb: run `sudo apt-get install -y xvfb`", pytrace=False)
    return name


@pytest.fixture(scope="session")
def qapp_cls(xvfb: str) -> type:
    """Have every test that uses Qt fail clearly without a display, instead of aborting inside Qt."""
    from PySide6.QtWidgets import QApplication

    return QApplication


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder with the real data sets, which are not part of the project: without them the test is skipped."""
    folder = REPOSITORY.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the real data sets are not on this machine")
    return folder


def _python_threads() -> set[threading.Thread]:
    """Threads started from Python, but for those that stay to help; those that Numba, VTK and Qt start themselves are
    not in the list."""
    from riglens.core.in_threads import HELPER  # not before the environment is set

    every = (one for one in threading.enumerate() if not isinstance(one, threading._DummyThread))
    return {one for one in every if not one.name.startswith(HELPER)}


@pytest.fixture(autouse=True)
def no_leaked_threads() -> Iterator[None]:
    """Fail a test that leaves a thread running behind."""
    before = _python_threads()
    yield
    deadline = time.monotonic() + THREAD_GRACE_S
    while (leaked := _python_threads() - before) and time.monotonic() < deadline:
        time.sleep(0.01)
    if leaked:
        names = ", ".join(sorted(thread.name for thread in leaked))
        pytest.fail(f"the test left threads running: {names}", pytrace=False)
