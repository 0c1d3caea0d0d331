"""Time left is a steady guess from the pace so far, told in words that are no finer than it is."""

import pytest

from riglens.widgets.panels.controls.messages import TimeLeft, duration_text


class Clock:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def test_at_an_even_pace_the_guess_is_right() -> None:
    clock = Clock()
    left = TimeLeft(clock)
    for step in range(1, 10):
        clock.now_s += 2.0
        left.note(step / 10)
        assert left.seconds == pytest.approx(20.0 - 2.0 * step)


def test_nothing_is_guessed_before_there_is_something_to_go_by() -> None:
    clock = Clock()
    left = TimeLeft(clock)
    left.note(0.0)
    clock.now_s += 0.2
    left.note(0.5)
    assert left.seconds is None


def test_the_first_steps_which_load_code_promise_nothing() -> None:
    clock = Clock()
    left = TimeLeft(clock)
    clock.now_s += 20.0
    left.note(0.01)
    assert left.seconds is None
    left.note(0.5)
    assert left.seconds == pytest.approx(20.0)


def test_work_that_stalls_is_never_late_by_a_negative_time() -> None:
    clock = Clock()
    left = TimeLeft(clock)
    clock.now_s += 2.0
    left.note(0.9)
    clock.now_s += 60.0
    assert left.seconds == 0.0


def test_one_slow_step_does_not_throw_the_guess_about() -> None:
    clock = Clock()
    left = TimeLeft(clock)
    for step in range(1, 6):
        clock.now_s += 1.0
        left.note(step / 10)
    clock.now_s += 5.0
    left.note(0.6)
    assert left.seconds is not None
    assert 0.0 < left.seconds < 6.7


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "1 s"),
        (12.4, "12 s"),
        (59.0, "59 s"),
        (180.0, "3 min"),
        (3600.0, "1 h 0 min"),
        (4800.0, "1 h 20 min"),
    ],
)
def test_durations_are_told_in_one_or_two_words(seconds: float, text: str) -> None:
    assert duration_text(seconds) == text
