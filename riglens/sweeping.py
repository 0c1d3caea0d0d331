"""Sweeps for scripts: figures of many rigs that differ in some fields, as one table."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Unpack

from numpy.typing import ArrayLike

from riglens.arguments import BoxReading, StrPath, Warnings, reads_boxes, scene_options
from riglens.core.metric.scores import DEFAULT_LAMBDA, Body, Method, Reading
from riglens.core.rig.model import Rig
from riglens.core.sweep.design import Span
from riglens.core.sweep.table import document_of, header_of, main_figures, write
from riglens.core.targets.settings import Phase
from riglens.core.targets.shapes import Shape
from riglens.core.targets.traffic import WITHIN_M
from riglens.evaluation.options import CountOptions, ScoreOptions
from riglens.results import Result, Rows
from riglens.scenes import with_blocking_meshes

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pyarrow import Table

__all__ = ["SweepResult", "sweep"]


@dataclass(frozen=True, eq=False)
class SweepResult(Result):
    """Result of a sweep: `table()` has one row per rig with every figure, `header` data, settings and hashes."""

    _table: Table

    @property
    def header(self) -> dict[str, Any]:
        """Data, settings, rigs, design and noise floor of all rows."""
        return header_of(self._table)

    def table(self) -> Table:
        """Return all columns as an Arrow table; `.to_pandas()` where pandas is installed."""
        return self._table

    def rows(self) -> Rows:
        """Return rig, varied fields and main figures."""
        columns = ["rig", *self.header["design"]["fields"], *main_figures(self._table)]
        found: Rows = self._table.select(columns).to_pylist()
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return header and rows as JSON-able data."""
        return document_of(self._table)

    def save(self, path: StrPath) -> None:
        """Write the table as a Parquet file, as the command does."""
        write(self._table, Path(path))

    def chart(self, *figures: str) -> Figure:
        """Return a chart of some columns over the one or two varied fields; hit coverage by default."""
        from riglens.studies.sweep_chart import sweep_figure  # matplotlib

        return sweep_figure(self._table, figures)

    def __repr__(self) -> str:
        return f"<SweepResult: {self._table.num_rows:,} rigs, {self._table.num_columns} columns>"


@reads_boxes
def sweep(
    rigs: Rig | Sequence[Rig],
    vary: Mapping[str, Sequence[float]] | None = None,
    boxes: StrPath | None = None,
    *,
    out: StrPath | None = None,
    sobol: int | None = None,
    design_seed: int = 0,
    design: StrPath | None = None,
    compute: Literal["score", "targets"] | None = None,
    blind_m: float | None = None,
    voxel_m: float | None = None,
    roi_m: ArrayLike | None = None,
    pog: StrPath | None = None,
    surroundings: bool = False,
    occluders: tuple[StrPath, StrPath] | None = None,
    within_m: float = WITHIN_M,
    sample: int = 100,
    shape: Shape = "class",
    range_law: bool = True,
    phase: Phase = "random",
    seed: int = 0,
    min_points: int = 5,
    calibration: StrPath | None = None,
    method: Method = "exact",
    reading: Reading = "covered",
    camera_weight: float = DEFAULT_LAMBDA,
    body: Body | None = None,
    threads: int | None = None,
    workers: int | None = None,
    dask: str | None = None,
    mesh_folder: StrPath = ".",
    **read_as: Unpack[BoxReading],
) -> SweepResult:
    """Evaluate many rigs that differ in some fields, as `riglens sweep` does; see docs/sweep.md.

    The other arguments are those of `load_scene`, `load_traffic`, `score` and `targets`. Raises InputError for a field
    that is not there, a value that does not fit, or arguments that disagree.

    Parameters
    ----------
    rigs
        Rig, or several; each gets every value.
    vary
        Fields and their values: {"LIDAR_TOP.z": (1.6, 2.2, 13)} from, to, how many; all combinations of several.
    out
        Parquet file to write; an interrupted call with it resumes.
    sobol, design_seed
        Vary all fields at once over this number of points of a Sobol sequence: {"LIDAR_TOP.z": (1.6, 2.2)}.
    design
        Take the values from a CSV or Parquet file with a column per field.
    compute, blind_m
        Scores or hit coverage alone; also the blind area of an object of this height.
    sample
        Number of frames in which objects are counted.
    calibration
        File of a calibration of predicted detection.
    workers, dask
        Processes, one per core by default, or the scheduler of a Dask cluster. A script that uses several processes
        needs `if __name__ == "__main__":` around its work.
    """
    from riglens.core.pieces.backend import Backend
    from riglens.jobs.sweeping import DesignOptions, swept

    table = None if design is None else Path(design)
    how = DesignOptions(sobol=sobol, table=table, design_seed=design_seed, compute=compute, blind_m=blind_m)
    made = how.design([Span.of(field, values) for field, values in (vary or {}).items()])
    scene = scene_options(
        boxes,
        voxel_m=voxel_m,
        roi_m=roi_m,
        pog=pog,
        surroundings=surroundings,
        occluders=occluders,
        **read_as,
    )
    score = ScoreOptions(method, reading, camera_weight, threads, body)
    curves = None if calibration is None else Path(calibration)
    count = CountOptions(within_m, sample, shape, range_law, phase, seed, min_points, curves)
    several = with_blocking_meshes(rigs, score, mesh_folder)
    figures = how.figures(scene, count, score)
    with tempfile.TemporaryDirectory(prefix="riglens-") as folder:
        path = Path(folder) / "sweep.parquet" if out is None else Path(out)
        backend = Backend(workers, dask)
        return SweepResult(swept(several, made, figures, scene, within_m, score, path, backend, Warnings()))
