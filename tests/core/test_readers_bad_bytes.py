"""Whatever the bytes of the input turn into, a reader reads it or refuses it in one line: no crash, no hang."""

import pickle
import shutil
import signal
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.scene.readers import open_boxes
from tests.core.broken_files import SOURCES, Sound, broken_versions, carla_file, csv_file

QUICK, LONG = 60, 12_000
CPU_SECONDS_PER_FILE = 30


def refused(path: Path) -> bool:
    """Whether the data are refused, in one line; if they are read, the boxes have to be boxes."""
    try:
        with warnings.catch_warnings(action="ignore"):
            source = open_boxes(path)
            for batch in source.batches():
                assert np.isfinite(batch.centre_m).all()
                assert np.isfinite(batch.rotation).all()
                assert (batch.size_m > 0).all()
                assert (np.diff(batch.frame) >= 0).all()
            report = source.report()
            assert report.frames > 0
            assert len(source.content_hash) == 64
    except InputError as error:
        assert str(error).isprintable() and len(str(error)) < 1000
        return True
    return False


@contextmanager
def no_hang() -> Iterator[None]:
    """Fail when the block takes that much time of the processor; time spent waiting does not count."""

    def fail(*_: object) -> None:
        raise AssertionError(f"more than {CPU_SECONDS_PER_FILE} s on a file of some kilobytes")

    before = signal.signal(signal.SIGVTALRM, fail)
    signal.setitimer(signal.ITIMER_VIRTUAL, CPU_SECONDS_PER_FILE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def try_all(sound: Sound, count: int, seed: int) -> int:
    """How many broken versions are refused; names the one that does anything else."""
    assert not refused(sound.path)
    total = 0
    for number, victim in enumerate(broken_versions(sound, count, seed)):
        try:
            with no_hang():
                total += refused(sound.path)
        except BaseException as error:
            error.add_note(f"seed {seed}, number {number}, {victim.name}: {victim.read_bytes()!r}")
            raise
    return total


@pytest.mark.parametrize("make", SOURCES, ids=lambda make: make.__name__)
def test_broken_bytes_are_read_or_refused_in_one_line(tmp_path: Path, make: Callable[[Path], Sound]) -> None:
    assert try_all(make(tmp_path), QUICK, seed=20260) > 12


@pytest.mark.slow
@pytest.mark.parametrize("make", SOURCES, ids=lambda make: make.__name__)
def test_very_many_broken_files_are_read_or_refused(tmp_path: Path, make: Callable[[Path], Sound]) -> None:
    assert try_all(make(tmp_path), LONG, seed=1) > LONG // 8


def test_pickles_are_never_unpickled(tmp_path: Path) -> None:
    class Bomb:
        def __reduce__(self) -> tuple[object, tuple[str]]:
            return Path.touch, (tmp_path / "exploded",)  # type: ignore[return-value]

    sound = carla_file(tmp_path)
    objects = tmp_path / "objects.npy"
    np.save(objects, np.array([Bomb()] * 8, dtype=object), allow_pickle=True)
    for data in (pickle.dumps(Bomb()), objects.read_bytes(), pickle.dumps(np.zeros((8, 3)))):
        sound.files[0].write_bytes(data)
        with pytest.raises(InputError, match="pickled objects"):
            list(open_boxes(sound.path).batches())
    assert not (tmp_path / "exploded").exists()


def test_a_file_that_cannot_be_opened_is_named(tmp_path: Path) -> None:
    path = csv_file(tmp_path).path
    source = open_boxes(path)
    path.unlink()
    path.mkdir()
    with pytest.raises(InputError, match=r"boxes\.csv: cannot be read"):
        list(source.batches())
    shutil.rmtree(path)
    with pytest.raises(InputError, match=r"boxes\.csv: cannot be read"):
        _ = source.content_hash
