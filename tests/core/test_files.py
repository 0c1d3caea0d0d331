"""Writing files: all or nothing, and one clear line when a target cannot be written."""

import ctypes
import errno
import io
import os
import shutil
import signal
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.files import (
    atomic_folder,
    atomic_write,
    hold_lock,
    read_csv,
    release_lock,
    require_writable,
)


def test_bytes_and_text_appear_under_the_name_asked_for(tmp_path: Path) -> None:
    with atomic_write(tmp_path / "a.bin") as stream:
        stream.write(b"\x00\r\n")
    with atomic_write(tmp_path / "a.txt", "w") as text:
        text.write("δ = 0.1\r\nx\n")
    assert (tmp_path / "a.bin").read_bytes() == b"\x00\r\n"
    assert (tmp_path / "a.txt").read_bytes() == "δ = 0.1\r\nx\n".encode()
    assert sorted(os.listdir(tmp_path)) == ["a.bin", "a.txt"]


def test_the_old_content_is_there_until_the_block_ends(tmp_path: Path) -> None:
    target = tmp_path / "rig.yaml"
    target.write_text("old", encoding="utf-8")
    with atomic_write(target, "w") as stream:
        stream.write("new")
        stream.flush()
        assert target.read_text(encoding="utf-8") == "old"
    assert target.read_text(encoding="utf-8") == "new"


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, SystemExit])
@pytest.mark.parametrize("existed", [True, False])
def test_an_interrupted_write_leaves_the_folder_as_it_was(
    tmp_path: Path, error: type[BaseException], existed: bool
) -> None:
    target = tmp_path / "out.json"
    if existed:
        target.write_text("old", encoding="utf-8")
    with pytest.raises(error), atomic_write(target) as stream:
        stream.write(b"half")
        raise error()
    assert [(p.name, p.read_text(encoding="utf-8")) for p in tmp_path.iterdir()] == (
        [("out.json", "old")] if existed else []
    )


def test_a_full_disk_is_one_line_and_keeps_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "out.json"
    target.write_text("old", encoding="utf-8")
    with (
        pytest.raises(InputError, match=r"out\.json: cannot be written: No space left") as caught,
        atomic_write(target),
    ):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert "\n" not in str(caught.value)
    assert [p.read_text(encoding="utf-8") for p in tmp_path.iterdir()] == ["old"]


def test_an_error_of_another_file_is_not_blamed_on_the_target(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), atomic_write(tmp_path / "out.json"):
        (tmp_path / "missing").read_text(encoding="utf-8")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("nowhere/out.json", "no such folder"),
        ("folder", "got a folder"),
        ("file/out.json", "no such folder"),
        ("n" * 300, "cannot be written"),
    ],
)
def test_a_target_that_cannot_be_written_is_refused_in_one_line(
    tmp_path: Path, name: str, complaint: str
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("x", encoding="utf-8")
    before = sorted(os.listdir(tmp_path))
    with pytest.raises(InputError, match=complaint) as caught, atomic_write(tmp_path / name) as stream:
        stream.write(b"x")
    assert "\n" not in str(caught.value) and name in str(caught.value)
    assert sorted(os.listdir(tmp_path)) == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_write_protected_folder_or_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("old", encoding="utf-8")
    (tmp_path / "mine").chmod(0o444)
    with pytest.raises(InputError, match="write-protected"), atomic_write(tmp_path / "mine"):
        pass
    tmp_path.chmod(0o555)
    with pytest.raises(InputError, match="Permission denied"), atomic_write(tmp_path / "new"):
        pass
    tmp_path.chmod(0o755)


def test_permissions_and_links_stay(tmp_path: Path) -> None:
    real = tmp_path / "real.yaml"
    real.write_text("old", encoding="utf-8")
    real.chmod(0o640)
    link = tmp_path / "link.yaml"
    link.symlink_to(real)
    with atomic_write(link, "w") as stream:
        stream.write("new")
    assert link.is_symlink() and real.read_text(encoding="utf-8") == "new"
    assert real.stat().st_mode & 0o777 == 0o640


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="this system has no such devices")
def test_devices_are_written_and_not_replaced() -> None:
    """A terminal of the test's own: nothing can be put in its place, whatever is wrong (/dev/null could go)."""
    reading, writing = os.openpty()
    with atomic_write(os.ttyname(writing)) as stream:
        stream.write(b"x")
    assert os.read(reading, 10) == b"x"
    os.close(reading)
    os.close(writing)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_in_a_folder_is_written_and_not_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    end = os.open(tmp_path / "pipe", os.O_RDWR)
    with atomic_write(tmp_path / "pipe") as stream:
        stream.write(b"x")
    assert (tmp_path / "pipe").is_fifo() and os.read(end, 10) == b"x"
    os.close(end)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_that_no_process_reads_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="not a regular file"), atomic_write(tmp_path / "pipe"):
        pass
    assert (tmp_path / "pipe").is_fifo()


def test_a_pipe_that_has_no_name_is_written(tmp_path: Path) -> None:
    reading, writing = os.pipe()
    with atomic_write(f"/dev/fd/{writing}") as stream:
        stream.write(b"x")
    os.close(writing)
    with os.fdopen(reading, "rb") as end:
        assert end.read() == b"x"


def test_a_path_too_long_for_the_temporary_file_is_found_before_the_work(tmp_path: Path) -> None:
    deep = tmp_path
    while len(os.fsencode(deep)) < 4040 - 200:
        deep /= "d" * 100
    deep.mkdir(parents=True)
    last = deep / ("d" * (4080 - len(os.fsencode(deep))))
    last.mkdir()
    with pytest.raises(InputError, match="File name too long"):
        require_writable(last / "a.npz")
    require_writable(deep / "a.npz")
    shutil.rmtree(tmp_path / ("d" * 100))


def test_a_folder_that_may_not_be_written_is_found_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_access(path: Path, mode: int) -> bool:  # also where the tests run as root
        return path != tmp_path

    monkeypatch.setattr(os, "access", no_access)
    with pytest.raises(InputError, match=r"new\.npz: cannot be written: Permission denied in "):
        require_writable(tmp_path / "new.npz")


def test_a_folder_appears_whole_and_is_replaced_whole(tmp_path: Path) -> None:
    target = tmp_path / "kit"
    atomic_folder(target, {"a.yaml": b"one", "b.yaml": b"two"})
    atomic_folder(target, {"a.yaml": b"three", "b.yaml": b"four"})
    assert {path.name: path.read_bytes() for path in target.iterdir()} == {
        "a.yaml": b"three",
        "b.yaml": b"four",
    }
    assert list(tmp_path.iterdir()) == [target]


def test_a_folder_with_other_files_is_left_alone(tmp_path: Path) -> None:
    target = tmp_path / "home"
    target.mkdir()
    (target / "thesis.tex").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"home: cannot be written: .*holds thesis\.tex"):
        atomic_folder(target, {"a.yaml": b"one"})
    assert [path.name for path in target.iterdir()] == ["thesis.tex"]


def test_a_folder_that_cannot_be_filled_leaves_nothing_and_the_old_one_as_it_was(tmp_path: Path) -> None:
    target = tmp_path / "kit"
    atomic_folder(target, {"a.yaml": b"one"})
    with pytest.raises(InputError, match="cannot be written"):
        atomic_folder(target, {"a.yaml": b"two", "no/such/place": b"three"})
    assert (target / "a.yaml").read_bytes() == b"one" and list(tmp_path.iterdir()) == [target]
    for place, complaint in (
        (tmp_path / "no" / "kit", "no such folder"),
        (target / "a.yaml", "must be a folder"),
    ):
        with pytest.raises(InputError, match=complaint):
            atomic_folder(place, {"a.yaml": b"two"})


# ---------------------------------------------------------------- a power cut, and runs that were killed


def write_file(target: Path, content: bytes) -> None:
    with atomic_write(target) as stream:
        stream.write(content)


def write_folder(target: Path, content: bytes) -> None:
    atomic_folder(target, {"a.yaml": content})


@pytest.mark.parametrize("write", [write_file, write_folder])
def test_content_is_on_the_disk_before_it_gets_its_name_and_the_name_after(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Callable[[Path, bytes], None]
) -> None:
    done: list[tuple[str, object]] = []
    fsync, replace, rename = os.fsync, os.replace, os.rename

    def flush(descriptor: int) -> None:
        what = os.fstat(descriptor)
        done.append(("fsync", "folder" if stat.S_ISDIR(what.st_mode) else what.st_size))
        fsync(descriptor)

    def put(how: Callable[[Path, Path], None]) -> Callable[[Path, Path], None]:
        return lambda one, other: (done.append(("name", other.name)), how(one, other))[1]

    monkeypatch.setattr(os, "fsync", flush)
    monkeypatch.setattr(os, "replace", put(replace))
    monkeypatch.setattr(os, "rename", put(rename))
    write(tmp_path / "new", b"12345")
    assert done == [("fsync", 5), ("name", "new"), ("fsync", "folder")]


KILLED = """
import os, signal, sys
from pathlib import Path
from riglens.core import files
def die(*_, **__):
    os.kill(os.getpid(), signal.SIGKILL)
target, where = Path(sys.argv[1]), sys.argv[2]
if where == "file":
    with files.atomic_write(target) as stream:
        stream.write(b"half")
        stream.flush()
        die()
if where == "exchange":
    rename = os.rename
    os.rename = lambda one, other: (rename(one, other), die())
if where == "clearing":
    files.shutil.rmtree = die
if where == "filling":
    os.fsync = die
files.atomic_folder(target, {"a.yaml": b"new"})
"""


def killed(target: Path, where: str) -> None:
    """Write the target in a process that is killed meanwhile."""
    done = subprocess.run([sys.executable, "-c", KILLED, str(target), where], check=False)
    assert done.returncode == -signal.SIGKILL


def made_old(folder: Path) -> None:
    """Make everything in the folder some days old."""
    for path in folder.iterdir():
        os.utime(path, (0, 0))


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system ends processes in another way")
@pytest.mark.parametrize("where", ["filling", "exchange", "clearing"])
def test_a_folder_whose_exchange_is_killed_is_whole_at_the_next_write_and_nothing_else_is_left(
    tmp_path: Path, where: str
) -> None:
    target = tmp_path / "kit"
    atomic_folder(target, {"a.yaml": b"old"})
    killed(target, where)
    assert len(list(tmp_path.iterdir())) == 2
    write_file(tmp_path / "other", b"")
    assert (target / "a.yaml").read_bytes() == (b"new" if where == "clearing" else b"old")
    made_old(tmp_path)
    write_file(tmp_path / "other", b"")
    assert sorted(os.listdir(tmp_path)) == ["kit", "other"]
    assert (target / "a.yaml").read_bytes() == (b"new" if where == "clearing" else b"old")


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system ends processes in another way")
def test_what_a_killed_run_left_is_removed_once_it_is_old(tmp_path: Path) -> None:
    (tmp_path / "rig.yaml").write_text("old", encoding="utf-8")
    killed(tmp_path / "rig.yaml", "file")
    assert (tmp_path / "rig.yaml").read_text(encoding="utf-8") == "old"
    write_file(tmp_path / "another.yaml", b"")
    assert len(os.listdir(tmp_path)) == 3  # it might still be written
    made_old(tmp_path)
    write_file(tmp_path / "another.yaml", b"")
    assert sorted(os.listdir(tmp_path)) == ["another.yaml", "rig.yaml"]


def test_what_is_being_written_and_files_of_users_are_left_alone(tmp_path: Path) -> None:
    kept = {".a.tmp", ".a.0123456789ab.tmp", "a.riglens-0123456789ab.tmp", ".a.riglens-0123456789ab.tmpx"}
    with atomic_write(tmp_path / "rig.yaml"):
        for name in kept:
            (tmp_path / name).touch()
            os.utime(tmp_path / name, (0, 0))
        write_file(tmp_path / "b", b"")
    assert set(os.listdir(tmp_path)) == {*kept, "b", "rig.yaml"}


# ---------------------------------------------------------------- locks


def test_a_lock_has_one_holder_in_this_process_too_and_leaves_no_file(tmp_path: Path) -> None:
    lock = hold_lock(tmp_path / "lock")
    with pytest.raises(BlockingIOError):
        hold_lock(tmp_path / "lock")
    release_lock(lock)
    assert not list(tmp_path.iterdir())
    release_lock(hold_lock(tmp_path / "lock"))


def test_a_killed_process_gives_its_lock_back(tmp_path: Path) -> None:
    holder = (
        "import sys; from pathlib import Path; from riglens.core.files import hold_lock\n"
        "lock = hold_lock(Path(sys.argv[1])); print('held', flush=True); sys.stdin.read()"
    )
    command = [sys.executable, "-c", holder, str(tmp_path / "lock")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline().strip() == b"held"
        with pytest.raises(BlockingIOError):
            hold_lock(tmp_path / "lock")
        process.kill()
    release_lock(hold_lock(tmp_path / "lock"))


@pytest.mark.parametrize("name", ["n" * 255, "δ" * 127])
def test_the_longest_names_can_be_written(tmp_path: Path, name: str) -> None:
    write_file(tmp_path / name, b"x")
    assert os.listdir(tmp_path) == [name]


@pytest.mark.skipif(sys.platform != "linux", reason="asks the C library of Linux for the handler")
def test_ctrl_c_stays_with_python_while_a_table_is_parsed() -> None:
    def handler() -> bytes:
        action = ctypes.create_string_buffer(512)
        ctypes.CDLL(None).sigaction(signal.SIGINT, None, action)
        return action.raw[:8]

    class Source(io.BytesIO):
        def read(self, size: int | None = -1) -> bytes:
            handlers.add(handler())
            return super().read(size)

    handlers = {handler()}
    assert read_csv(Source(b"a,b\n1,2\n")).to_pylist() == [{"a": 1, "b": 2}]
    assert len(handlers) == 1
