"""Reading has a limit in seconds, by a clock that tests turn by hand; what is done with the data does not count."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.formats.exchange import read_rig
from riglens.core.reading_time import MAX_BOXES_S, MAX_RIG_S, ReadingTime
from riglens.core.scene.readers import open_boxes
from tests.core.formats.cases import SMALL, write_files
from tests.core.sound_boxes import SOURCES, Sound


def slow(step_s: float) -> Callable[[], float]:
    """A clock that goes on by so much whenever somebody looks."""
    times: Iterator[float] = iter(step_s * number for number in range(10**9))
    return lambda: next(times)


@pytest.mark.parametrize("case", SMALL)
def test_a_rig_that_takes_too_long_is_refused_with_its_name_and_the_limit(tmp_path: Path, case: str) -> None:
    place = write_files(tmp_path / case, SMALL[case])
    path = place / next(iter(SMALL[case])) if len(SMALL[case]) == 1 else place
    assert read_rig(path, clock=slow(1e-6)).rig.sensors
    with pytest.raises(InputError, match="reading took longer than 60 s") as caught:
        read_rig(path, clock=slow(MAX_RIG_S + 1.0))
    assert path.name in str(caught.value)


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.__name__)
def test_boxes_that_take_too_long_are_refused_with_their_name_and_the_limit(
    tmp_path: Path, source: Callable[[Path], Sound]
) -> None:
    path = source(tmp_path).path
    for part in open_boxes(path).parts():
        assert list(part.batches(clock=slow(1e-6))) is not None
        with pytest.raises(InputError, match="reading took longer than 14400 s") as caught:
            list(part.batches(clock=slow(MAX_BOXES_S + 1.0)))
        assert path.name in str(caught.value)


def test_what_is_done_with_the_data_takes_no_reading_time() -> None:
    now_s = [0.0]
    taken = ReadingTime("boxes.csv", 10.0, lambda: now_s[0])
    now_s[0] = 9.0
    taken.pause()
    now_s[0] = 500.0
    taken.check()
    taken.go_on()
    now_s[0] = 500.9
    taken.check()
    assert taken.taken_s == pytest.approx(9.9)
    now_s[0] = 501.1
    with pytest.raises(InputError, match=r"boxes\.csv: reading took longer than 10 s"):
        taken.check()
