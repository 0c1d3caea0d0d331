"""Designs: which values the varied fields have in each rig of a sweep."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular, read_csv
from riglens.core.rig.model import Rig
from riglens.core.sweep.fields import RigField, fields_called, with_values

MAX_RIGS = 1_000_000
MAX_BYTES = 1 << 28
"""Of a table of values."""
CHECKED = 1000
"""Rigs that are made before the work to find values that do not fit."""
_DIGITS = 12
"""Decimals of evenly spaced values: 1.7, not 1.7000000000000002."""


@dataclass(frozen=True)
class Span:
    """Values of one field: from `first` to `last`, `count` of them in a grid."""

    field: str
    first: float
    last: float
    count: int | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.first) and math.isfinite(self.last)):
            raise InputError(f"'{self.field}' must range between finite numbers", "vary")
        if self.count is not None and self.count < 1:
            raise InputError(f"'{self.field}': number of values must be ≥ 1 (got {self.count})", "vary")
        if self.count == 1 and self.first != self.last:
            raise InputError(f"'{self.field}': number of values must be ≥ 2 unless FROM = TO (got 1)", "vary")

    @classmethod
    def of(cls, field: str, values: Sequence[float]) -> Span:
        """Return the span of a field: from, to, and how many values in a grid."""
        if len(values) not in (2, 3):
            raise InputError(
                f"'{field}' must have FROM, TO and the number of values (got {len(values)})", "vary"
            )
        count = None if len(values) == 2 else values[2]
        if count is not None and count != int(count):
            raise InputError(f"'{field}': number of values must be an integer (got {count:g})", "vary")
        return cls(field, float(values[0]), float(values[1]), None if count is None else int(count))

    @classmethod
    def parsed(cls, text: str) -> Span:
        """Return the span in a text FIELD=FROM:TO:N, or FIELD=FROM:TO."""
        field, equals, values = text.rpartition("=")
        words = values.split(":")
        try:
            if not field or not equals or len(words) not in (2, 3):
                raise ValueError
            return cls(field, float(words[0]), float(words[1]), int(words[2]) if len(words) == 3 else None)
        except InputError:
            raise
        except ValueError:
            raise InputError(f"must be FIELD=FROM:TO:N (got '{text:.80}')", "vary") from None


@dataclass(frozen=True, eq=False)
class Design:
    """Values (rigs, fields) of the fields of these names."""

    kind: Literal["grid", "sobol", "table"]
    names: tuple[str, ...]
    values: NDArray[np.float64]


def grid(spans: Sequence[Span]) -> Design:
    """Return all combinations of evenly spaced values; those of the last field change fastest."""
    for span in spans:
        if span.count is None:
            raise InputError(f"'{span.field}' lacks the number of values: FIELD=FROM:TO:N", "vary")
    counts = [span.count or 1 for span in spans]
    _require_rigs(math.prod(counts))
    values = [
        np.round(np.linspace(s.first, s.last, n), _DIGITS).tolist()
        for s, n in zip(spans, counts, strict=True)
    ]
    return Design("grid", tuple(span.field for span in spans), np.array(list(product(*values)), np.float64))


def sobol(spans: Sequence[Span], count: int, seed: int = 0) -> Design:
    """Return `count` points of a scrambled Sobol sequence; more points begin with the same ones."""
    from scipy.stats import qmc  # slow to load

    if count < 1:
        raise InputError(f"must be an integer ≥ 1 (got {count})", "sobol")
    if not 0 <= seed < 1 << 63:
        raise InputError(f"must be an integer from 0 to 2^63 - 1 (got {seed})", "seed")
    for span in spans:
        if span.count is not None:
            raise InputError(
                f"'{span.field}' has a number of values; with Sobol points give FIELD=FROM:TO", "vary"
            )
    _require_rigs(count)
    if not spans:
        raise InputError("needs fields to vary; specify them with", "sobol", "vary")
    sampler = qmc.Sobol(len(spans), scramble=True, rng=np.random.default_rng(seed))
    units = sampler.random_base2(math.ceil(math.log2(count)))[:count]
    first, last = (np.array([getattr(span, name) for span in spans]) for name in ("first", "last"))
    return Design(
        "sobol", tuple(span.field for span in spans), np.round(first + (last - first) * units, _DIGITS)
    )


def table(path: Path) -> Design:
    """Return the values in a CSV or Parquet file, whose columns are named like fields; one row is one rig."""
    import pyarrow as pa
    from pyarrow import parquet

    accepted = "a table (CSV or Parquet) with a column per field"
    try:
        with open_regular(path, accepted) as file:
            if file.seek(0, os.SEEK_END) > MAX_BYTES:
                raise InputError(f"{path}: must be at most {MAX_BYTES >> 20} MiB")
            file.seek(0)
            is_csv = path.suffix.lower() == ".csv"
            if not is_csv:
                _require_rigs(parquet.ParquetFile(file).metadata.num_rows)  # a small file may hold many
            found = read_csv(file) if is_csv else parquet.read_table(file)
    except InputError:
        raise
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file (must be {accepted})") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (pa.ArrowException, ValueError) as error:
        raise InputError(f"{path}: not {accepted}: {str(error).splitlines()[0]:.200}") from error
    _require_rigs(found.num_rows)
    columns = []
    for name, column in zip(found.column_names, found.columns, strict=True):
        is_number = pa.types.is_integer(column.type) or pa.types.is_floating(column.type)
        values = column.to_numpy().astype(np.float64) if is_number else np.array([np.nan])
        if not np.isfinite(values).all():
            raise InputError(f"{path}: column '{name}' must hold finite numbers only")
        columns.append(values)
    return Design("table", tuple(found.column_names), np.column_stack(columns))


def _require_rigs(count: int) -> None:
    if not 1 <= count <= MAX_RIGS:
        raise InputError(f"a sweep must hold 1 to {MAX_RIGS:,} rigs (got {count:,})")


@dataclass(frozen=True, eq=False)
class Sweep:
    """Rigs to be evaluated, n of them: `base` (n,) which of `rigs` each varies, and `values` (n, fields) of the fields
    of these names."""

    rigs: tuple[Rig, ...]
    names: tuple[str, ...]
    base: NDArray[np.int64]
    values: NDArray[np.float64]

    @classmethod
    def of(cls, rigs: Sequence[Rig], design: Design) -> Sweep:
        """Return every rig with every row of a design; raise InputError for fields or values that do not fit."""
        count = len(design.values)
        _require_rigs(len(rigs) * count)
        base = np.repeat(np.arange(len(rigs)), count)
        found = cls(tuple(rigs), design.names, base, np.tile(design.values, (len(rigs), 1)))
        found._check()
        return found

    def __len__(self) -> int:
        return len(self.base)

    def part(self, rows: range) -> Sweep:
        """Return some rows that follow one another."""
        base = self.base[rows.start : rows.stop]
        rigs = self.rigs[base[0] : base[-1] + 1]
        return Sweep(rigs, self.names, base - base[0], self.values[rows.start : rows.stop])

    @cached_property
    def _fields(self) -> tuple[tuple[RigField, ...], ...]:
        return tuple(fields_called(rig, self.names) for rig in self.rigs)

    @property
    def fields(self) -> tuple[RigField, ...]:
        """The varied fields."""
        return self._fields[0]

    def rig(self, row: int) -> Rig:
        """Return the rig of a row; raise InputError for a value that does not fit."""
        base = int(self.base[row])
        return with_values(
            self.rigs[base], dict(zip(self._fields[base], self.values[row].tolist(), strict=True))
        )

    def _check(self) -> None:
        """Make the rigs with the least and the greatest value of each field, and some others."""
        rows = set(range(0, len(self), max(1, len(self) // CHECKED)))
        for base in range(len(self.rigs)):
            mine = np.flatnonzero(self.base == base)
            rows |= {
                int(mine[at]) for column in self.values[mine].T for at in (column.argmin(), column.argmax())
            }
        for row in sorted(rows):
            self.rig(row)
