"""Options and fixtures of the benchmarks, and the table and JSON file at their end.

`make bench` names the files bench_*.py explicitly; an ordinary test run does not collect them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from tests.bench.bars import Bar, bar_table, write_bars
from tests.bench.race import Race
from tests.bench.scenes import Scenes

ROUNDS, QUICK_ROUNDS = 12, 3
OUT = Path(__file__).resolve().parents[2] / "out"
COMPLETE, PARTIAL = OUT / "bench.json", OUT / "bench-partial.json"
FILES = tuple(Path(__file__).parent.glob("bench_*.py"))
BARS = pytest.StashKey[list[Bar]]()
NAMES = pytest.StashKey[set[str]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of `make bench`."""
    group = parser.getgroup("bars")
    group.addoption("--only", metavar="NAME", help="run one bar: bench_NAME.py")
    group.addoption(
        "--quick",
        action="store_true",
        help="voxels of twice the edge, three repetitions: to try the bench out",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Make room for the results."""
    config.stash[BARS] = []
    config.stash[NAMES] = set()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep the bar that --only names."""
    names = config.stash[NAMES] = {_bar_name(item.path) for item in items}
    only = config.getoption("only", None)
    if only is None:
        return
    if only not in names:
        raise pytest.UsageError(f"--only must be one of {', '.join(sorted(names))} (got {only!r})")
    items[:] = [item for item in items if _bar_name(item.path) == only]


def _bar_name(path: Path) -> str:
    return path.stem.removeprefix("bench_")


def _is_complete(config: pytest.Config) -> bool:
    """Whether every bar was asked for, in full."""
    chosen = any(config.getoption(option) for option in ("only", "quick", "keyword"))
    return not chosen and config.stash[NAMES] == {_bar_name(path) for path in FILES}


def pytest_terminal_summary(terminalreporter: Any, exitstatus: int, config: pytest.Config) -> None:
    """Print the table and write the JSON file; an incomplete run does not replace a complete one."""
    bars = config.stash[BARS]
    if not bars:
        return
    path = COMPLETE if exitstatus == 0 and _is_complete(config) else PARTIAL
    write_bars(bars, path)
    console = Console(width=None if terminalreporter.isatty else 150)
    console.print()
    console.print(bar_table(bars))
    reached = sum(bar.is_reached for bar in bars)
    console.print(f"{reached} of {len(bars)} goals reached. Written: {path.relative_to(OUT.parent)}")


@pytest.fixture(scope="session")
def is_quick(request: pytest.FixtureRequest) -> bool:
    """Whether this is only a trial of the bench."""
    return bool(request.config.getoption("quick"))


@pytest.fixture(scope="session")
def rounds(is_quick: bool) -> int:
    """Most repetitions of a race."""
    return QUICK_ROUNDS if is_quick else ROUNDS


@pytest.fixture(scope="session")
def scenes(is_quick: bool) -> Scenes:
    """The bundled scenario on any grid, each built once."""
    return Scenes(coarsen=2.0 if is_quick else 1.0)


@pytest.fixture
def bars(request: pytest.FixtureRequest) -> list[Bar]:
    """The results so far, to add one that is no race of two times."""
    return request.config.stash[BARS]


@pytest.fixture
def race(benchmark: Any, bars: list[Bar], rounds: int) -> Race:
    """Measures ours against a yardstick and adds the result."""
    return Race(benchmark, bars, rounds)
