"""The detector learns, the same each time, goes on where it was stopped, and says what to install without PyTorch."""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

from riglens.core.detect.net import (
    Machine,
    State,
    Training,
    detect,
    machine,
    require_torch,
    train,
    use_one_thread,
)
from riglens.core.detect.pillars import Samples
from riglens.core.detect.precision import Detections, Matched
from riglens.core.errors import InputError
from tests.core.detect.scenes import REGION, samples, truth_of

TRAINING = Training(epochs=3, batch=4)


@pytest.fixture
def one_thread() -> object:
    """One thread and the same way each time, for this test alone."""
    torch = pytest.importorskip("torch", reason="make test-detect")
    threads = torch.get_num_threads()
    use_one_thread()
    yield torch
    torch.use_deterministic_algorithms(False)
    torch.set_num_threads(threads)


def trained(epochs: int = 3, seed: int = 0) -> State:
    return train([samples(24, 1), samples(16, 2)], REGION, Training(epochs, 4, seed=seed), machine("cpu"))


def precisions(of: Samples, found: Detections) -> list[float]:
    """Of each class over all frames."""
    one = np.zeros(len(of), np.int64)
    return [float(Matched.of(truth_of(of), found, number, one).precision()[0]) for number in range(3)]


@pytest.mark.usefixtures("one_thread")
def test_it_learns() -> None:
    held, unseen = samples(160, 1), samples(40, 2)
    state = train([held], REGION, Training(epochs=8, batch=4), machine("cpu"))
    found = detect(state, unseen, REGION, machine("cpu"))
    assert min(precisions(unseen, found)) > 0.6
    before = detect(train([held], REGION, Training(epochs=0), machine("cpu")), unseen, REGION, machine("cpu"))
    assert max(precisions(unseen, before)) < 0.1


@pytest.mark.usefixtures("one_thread")
def test_the_same_seed_gives_the_same_bits_and_another_does_not() -> None:
    one, again, other = trained(), trained(), trained(seed=1)
    assert all((one[key] == again[key]).all() for key in one)
    assert not all((one[key] == other[key]).all() for key in one)


@pytest.mark.usefixtures("one_thread")
def test_stopped_after_any_epoch_it_ends_with_the_same_bits() -> None:
    sets, on = [samples(24, 1)], machine("cpu")
    whole = train(sets, REGION, TRAINING, on)
    states = [train(sets, REGION, TRAINING, on, until=epoch) for epoch in (1, 2, 3)]
    assert [int(state["epoch"]) for state in states] == [1, 2, 3]
    for state in states:
        resumed = train(sets, REGION, TRAINING, on, state)
        assert all((whole[key] == resumed[key]).all() for key in whole)


def _bits(_: int) -> bytes:
    use_one_thread()
    return b"".join(value.tobytes() for value in trained(1).values())


@pytest.mark.usefixtures("one_thread")
def test_a_process_of_its_own_gives_the_same_bits() -> None:
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert pool.submit(_bits, 0).result(timeout=120) == _bits(0)


@pytest.mark.usefixtures("one_thread")
def test_frames_without_points_or_objects_do_no_harm() -> None:
    empty = samples(4, 1)
    bare = empty.__class__(
        empty.frame, np.zeros(5, np.int64), empty.cell[:0], empty.features[:0], np.zeros(5, np.int64), empty.cls[:0],
        empty.centre_m[:0], empty.points[:0],
    )  # fmt: skip
    state = train([bare], REGION, Training(1, 2), machine("cpu"))
    assert all(np.isfinite(value).all() for value in state.values())
    assert detect(state, bare, REGION, machine("cpu")).centre_m.shape[1] == 2


def test_without_pytorch_one_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(InputError) as told:
        require_torch()
    assert "pip install 'riglens[detect]'" in str(told.value) and "\n" not in str(told.value)


def test_cuda_is_refused_where_there_is_none(one_thread: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("torch.cuda.is_available", lambda: False)
    with pytest.raises(InputError, match="cpu"):
        machine("cuda")
    found = machine()
    assert isinstance(found, Machine) and found.device == "cpu" and found.torch
