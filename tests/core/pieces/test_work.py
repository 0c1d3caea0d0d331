"""Work in pieces ends with the same bytes whatever the order, the workers and the interruptions."""

import json
import multiprocessing
import signal
from collections.abc import Callable, Collection
from concurrent.futures import Future
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.pieces.backend import Backend, workers_at
from riglens.core.pieces.folder import PieceFolder, count_kept, sole_run
from riglens.core.pieces.processes import worker_processes
from riglens.core.pieces.work import OwnProcess, Piece, Workers, results

COUNT = 8


def row(number: int) -> bytes:
    """One row of a sweep."""
    return json.dumps({"number": number, "square": number**2}).encode()


def sweep(folder: Path) -> PieceFolder[dict[str, int]]:
    """Rows are kept with their number as the key."""

    def read(key: str, content: bytes) -> dict[str, int]:
        found: dict[str, int] = json.loads(content)
        if found["number"] != int(key):
            raise ValueError("another row")
        return found

    return PieceFolder(folder, read)


def pieces(count: int = COUNT, work: Callable[..., bytes] = row) -> list[Piece]:
    return [Piece(str(number), work, lambda number=number: (number,)) for number in range(count)]


def squares(folder: Path, workers: Workers) -> list[int]:
    rows = [row for _, row in results(pieces(), sweep(folder), workers)]
    return [one["square"] for one in sorted(rows, key=lambda one: one["number"])]


EXPECTED = [number**2 for number in range(COUNT)]


class Late(OwnProcess):
    """Several workers that finish in an order drawn by the test."""

    def __init__(self, ahead: int, turns: st.DataObject | None = None) -> None:
        self.ahead, self.begun, self._turns = ahead, 0, turns

    def call(self, work: Callable[..., bytes], *arguments: object) -> Future[bytes]:
        self.begun += 1
        return super().call(work, *arguments)

    def wait(self, waiting: Collection[Future[bytes]]) -> Collection[Future[bytes]]:
        assert len(waiting) <= self.ahead
        if self._turns is None:
            return list(waiting)
        return self._turns.draw(st.lists(st.sampled_from(list(waiting)), min_size=1, unique=True))


@settings(max_examples=40)
@given(ahead=st.integers(1, 10), turns=st.data())
def test_the_order_in_which_workers_finish_changes_nothing(
    tmp_path_factory: pytest.TempPathFactory, ahead: int, turns: st.DataObject
) -> None:
    folder = tmp_path_factory.mktemp("sweep")
    assert squares(folder, Late(ahead, turns)) == EXPECTED
    assert {path.name for path in folder.iterdir()} == {f"{number}.piece" for number in range(COUNT)}


def test_processes_give_the_same_bytes(tmp_path: Path) -> None:
    with workers_at(Backend(2), COUNT) as workers:
        assert squares(tmp_path / "there", workers) == EXPECTED
    assert squares(tmp_path / "here", OwnProcess()) == EXPECTED
    one, other = (
        {path.name: path.read_bytes() for path in (tmp_path / name).iterdir()} for name in ("here", "there")
    )
    assert one == other


def test_what_was_interrupted_goes_on_where_it_was(tmp_path: Path) -> None:
    for piece, _ in results(pieces(), sweep(tmp_path), OwnProcess()):
        if piece.key == "2":
            break
    again = Late(1)
    assert len(list(results(pieces(), sweep(tmp_path), again))) == 8
    assert again.begun == 5


@pytest.mark.parametrize(
    "harm",
    [
        Path.unlink,
        lambda path: path.write_bytes(b""),
        lambda path: path.write_bytes(path.read_bytes()[:-1]),
        lambda path: path.write_bytes(path.read_bytes().replace(b"9", b"8")),
        lambda path: path.write_bytes((path.parent / "4.piece").read_bytes()),
        lambda path: (path.unlink(), path.mkdir()),
    ],
    ids=["deleted", "empty", "cut", "altered", "another piece", "a folder"],
)
def test_a_piece_that_is_not_as_it_was_written_is_made_again(
    tmp_path: Path, harm: Callable[[Path], object]
) -> None:
    squares(tmp_path, OwnProcess())
    harm(tmp_path / "3.piece")
    assert sweep(tmp_path).load("3") is None
    if (tmp_path / "3.piece").is_dir():
        (tmp_path / "3.piece").rmdir()
    again = Late(1)
    assert squares(tmp_path, again) == EXPECTED and again.begun == 1


def test_pieces_wait_for_those_that_they_need(tmp_path: Path) -> None:
    order = list[str]()

    def note(key: str) -> bytes:
        order.append(key)
        return b""

    needs = {"a": ("c", "d"), "b": ("a",), "c": (), "d": ("c", "elsewhere")}
    work = [Piece(key, note, lambda key=key: (key,), before) for key, before in needs.items()]
    store = PieceFolder(tmp_path, lambda _, content: content)
    assert len(list(results(work, store, Late(3)))) == 4
    assert order == ["c", "d", "a", "b"]
    with pytest.raises(ValueError, match="need each other: x, y"):
        list(results([Piece("x", note, tuple, ("y",)), Piece("y", note, tuple, ("x",))], store, Late(3)))


def test_pieces_that_are_done_when_another_fails_are_kept(tmp_path: Path) -> None:
    class Failing(Late):
        def call(self, work: Callable[..., bytes], *arguments: object) -> Future[bytes]:
            if arguments != (0,):
                return super().call(work, *arguments)
            failed = Future[bytes]()
            failed.set_exception(ChildProcessError("lost"))
            return failed

    with pytest.raises(ChildProcessError, match="lost"):
        squares(tmp_path, Failing(COUNT))
    assert count_kept(tmp_path) == COUNT - 1


def test_what_is_not_the_piece_is_refused_and_not_kept(tmp_path: Path) -> None:
    with pytest.raises(ChildProcessError, match=r"an unexpected result \(another row\)"):
        sweep(tmp_path).keep("3", row(4))
    assert count_kept(tmp_path) == 0


def test_a_cleared_folder_is_gone_unless_something_else_is_in_it(tmp_path: Path) -> None:
    for others in (0, 1):
        folder = tmp_path / str(others)
        squares(folder, OwnProcess())
        if others:
            (folder / "letter.txt").write_text("x", encoding="utf-8")
        sweep(folder).clear()
        assert [path.name for path in folder.glob("*")] == ["letter.txt"] * others
        assert folder.exists() == bool(others)


# ---------------------------------------------------------------- one run at a time


def test_a_second_run_in_a_folder_is_refused_and_a_later_one_is_not(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "work"
    with sole_run(folder):
        with (
            pytest.raises(InputError, match=r"work: another run uses this folder"),
            sole_run(folder),
        ):
            pass
        squares(folder, OwnProcess())
    assert count_kept(folder) == COUNT and not (folder / ".lock").exists()
    with sole_run(folder):
        sweep(folder).clear()
    assert not folder.exists()


def _hold(folder: Path, held: object) -> None:
    with sole_run(folder):
        held.set()  # type: ignore[attr-defined]
        signal.pause()


def test_a_killed_run_keeps_nobody_out(tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    held = context.Event()
    process = context.Process(target=_hold, args=(tmp_path / "work", held))
    process.start()
    held.wait()
    with pytest.raises(InputError, match="another run"), sole_run(tmp_path / "work"):
        pass
    process.kill()
    process.join()
    with sole_run(tmp_path / "work"):
        pass


# ---------------------------------------------------------------- processes


@pytest.mark.parametrize("workers", [0, -1, 1025])
def test_a_number_of_workers_is_a_count(workers: int) -> None:
    with pytest.raises(InputError, match=r"^workers must be between 1 and 1024"):
        Backend(workers)


def _threads_and_signals() -> bytes:
    return str(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())).encode()


def test_ctrl_c_never_reaches_a_worker_not_even_one_that_is_starting() -> None:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    with worker_processes(1) as workers:
        assert workers.call(_threads_and_signals).result() == b"True"
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == before


def test_a_killed_process_ends_the_work_with_one_line(tmp_path: Path) -> None:
    with pytest.raises(ChildProcessError, match="a worker process ended"), worker_processes(1) as workers:
        for _ in results(pieces(), sweep(tmp_path), workers):
            for process in multiprocessing.active_children():
                process.kill()
    assert count_kept(tmp_path) >= 1
    assert not multiprocessing.active_children()
