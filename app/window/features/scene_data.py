"""Box data: which traffic the rig is scored on, loaded in the background."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.status import scene_line
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.geometry import Vec3
from riglens.core.scene.grid import DEFAULT_ROI_M, DEFAULT_VOXEL_M, VoxelGrid
from riglens.core.scene.survey import doubtful
from riglens.evaluation.names import label_of, label_with
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.requests import LoadedScene
from riglens.evaluation.voxel_words import reason, tried_lines
from riglens.widgets.panels.controls.messages import Choices
from riglens.widgets.panels.scene.scene_panel import SceneChoice

PREPARING = ("Preparing the engine", "the first start compiles code for this rig")
QUIET_KEY = "scene/no_grid_note"
FILE_TIP = "Score on a CSV, CSV.gz or Parquet table, or on annotations.feather."
FOLDER_TIP = (
    "Score on a folder of nuScenes, Argoverse 2, KITTI, ONCE, ZOD, DAIR-V2X, OPV2V or CARLA, or of tables."
)


class SceneData(Feature):
    """Loads scenes into the session."""

    specs = (
        Spec(
            "boxes_file",
            "Box file…",
            FILE_TIP,
            "Ctrl+I",
            menu="scene/boxes",
        ),
        Spec(
            "boxes_folder",
            "Box folder…",
            FOLDER_TIP,
            "Ctrl+Shift+I",
            menu="scene/boxes",
        ),
    )

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self._options = SceneOptions()
        self._note = ""
        self._strip = bench.status.add_strip("Loading boxes")
        self._strip.cancel.setObjectName("cancel_load")
        choose_file = bench.guarded(lambda *_: self._choose(bench.dialogs.box_file(bench.window)))
        choose_folder = bench.guarded(lambda *_: self._choose(bench.dialogs.box_folder(bench.window)))
        self.bind(boxes_file=choose_file, boxes_folder=choose_folder)
        queued = Qt.ConnectionType.QueuedConnection
        bench.recompute.scene_loaded.connect(self._on_scene, queued)
        bench.recompute.load_progress.connect(self._strip.show_progress, queued)
        bench.recompute.load_preparing.connect(partial(self._strip.show_stage, *PREPARING), queued)
        bench.recompute.load_ended.connect(self._on_load_ended, queued)
        self._strip.cancelled.connect(bench.recompute.cancel_load)
        bench.panels.scene.load_wanted.connect(self._load_choice)
        bench.panels.scene.file_wanted.connect(choose_file)
        bench.panels.scene.folder_wanted.connect(choose_folder)

    @property
    def is_loading(self) -> bool:
        """Return whether a load is under way."""
        return self._strip.is_running

    def load(self, options: SceneOptions) -> None:
        """Load other box data in the background; an automatic voxel edge depends on the current rig."""
        settings, recompute = self.session.settings, self.bench.recompute
        score = ScoreOptions(
            settings.method, settings.reading, settings.camera_weight, recompute.threads, settings.body
        )  # fmt: skip
        self._options = options.for_rigs([self.document.rig], score)
        self._strip.begin()
        recompute.load(self._options)

    def load_path(self, path: Path, is_pog: bool) -> None:
        """Load a box data set on the grid in use, or a stored POG with its own; InputError for one without a known
        origin."""
        if is_pog:
            self.load(SceneOptions(pog=path))
            return
        self._choose(path)
        self._load_choice(self.bench.panels.scene.choice)

    def _load_choice(self, choice: SceneChoice) -> None:
        self.load(options_of(choice, self._options))

    def _on_scene(self, scene: LoadedScene) -> None:
        self._show_note(scene)
        self.viewport.show_state(replace(self.viewport.state, grid=scene.field.grid))
        self.bench.status.show_scene(scene)
        picked = tried = ""
        if scene.choice is not None:
            picked = f"Auto picked {reason(scene.choice)}. Load picks again for the current rig."
            tried = "\n".join(tried_lines(scene.choice))
        choice = choice_of(scene.options, scene.field.grid)
        self.bench.panels.scene.set_loaded(choice, f"In use: {scene_line(scene)}", picked, tried)
        self.session.show_scene(scene)

    def _show_note(self, scene: LoadedScene) -> None:
        """Show what is implausible about the data, or else that the numbers changed with the grid, unless the user
        opted out; another feature's note stays."""
        notes, before = self.bench.notes, self.session.scene
        if notes.message and notes.message != self._note:
            return
        choices: Choices = {}
        self._note = "\n".join(doubtful(scene.field.data, label_with))
        if self._note and scene.options.boxes is not None:
            choices[label_of("find_ground")] = partial(self.load, replace(scene.options, find_ground=True))
        if not self._note and before is not None and not self.bench.kept.read(QUIET_KEY, False):
            self._note = why_scores_move(before.field.grid, scene.field.grid)
            choices["Do not show this again"] = self._be_quiet
        if self._note:
            notes.show_message(self._note, choices=choices)
        else:
            notes.clear()

    def _be_quiet(self) -> None:
        self.bench.kept.write(QUIET_KEY, True)
        self.bench.kept.sync()

    def _on_load_ended(self, problem: str, options: SceneOptions) -> None:
        if options is not self._options:
            return  # another load was asked for meanwhile, and is under way
        self._strip.end()
        if problem:
            self.bench.report_error(problem)
            if self.session.scene is None:
                self.bench.status.set_no_data()
                self.bench.panels.scene.set_nothing_loaded()

    def _choose(self, path: Path | None) -> None:
        from riglens.core.scene.readers import (
            default_origin_m,  # many readers: not while the window opens
        )

        if path is not None:
            self.bench.panels.scene.choose_boxes(path, default_origin_m(path))
            self.bench.docks.bring_up("Scene")


def why_scores_move(before: VoxelGrid, after: VoxelGrid) -> str:
    """Explain how another voxel edge or region changes all scores; empty when both are the same."""
    reasons = []
    if before.voxel_m != after.voxel_m:
        reasons.append(f"voxels have edges of {after.voxel_m:g} m instead of {before.voxel_m:g} m")
    if before.roi_m != after.roi_m:
        old, new = (" × ".join(f"{length:g}" for length in grid.roi_m) for grid in (before, after))
        reasons.append(f"the region of interest is {new} m instead of {old} m")
    if not reasons:
        return ""
    return (
        f"All scores have changed although the rig has not: {' and '.join(reasons)}, so the sum of entropy differs. "
        "Compare scores of one grid only; the baseline is scored on the new grid too, so changes remain valid."
    )


def choice_of(options: SceneOptions, grid: VoxelGrid | None = None) -> SceneChoice:
    """Return the scene panel's content for these options; the grid of a stored POG is known once it is loaded."""
    voxel_m = None if options.voxel_m == "auto" else options.voxel_m or DEFAULT_VOXEL_M
    roi_m = options.roi_m or DEFAULT_ROI_M
    if options.pog is not None and grid is not None:
        voxel_m, roi_m = grid.voxel_m, grid.roi_m
    return SceneChoice(
        options.boxes,
        options.origin_m or _own_origin_m(options.boxes),
        options.frames,
        options.find_ground,
        voxel_m,
        roi_m,
        options.pog,
    )


def _own_origin_m(boxes: Path | None) -> Vec3:
    """Return the default origin of a data set; zero where there is none or it cannot be read."""
    with suppress(InputError):
        if boxes is not None:
            from riglens.core.scene.readers import default_origin_m

            return default_origin_m(boxes)
    return 0.0, 0.0, 0.0


def options_of(choice: SceneChoice, before: SceneOptions) -> SceneOptions:
    """Return the options for the scene panel's choice; what it does not show stays as long as the data set is the same,
    and an origin that the format fixes is not stated again."""
    if choice.pog is not None:
        return SceneOptions(pog=choice.pog)
    kept = before if choice.boxes == before.boxes else SceneOptions()
    is_stated = choice.boxes is not None and choice.origin_m != _own_origin_m(choice.boxes)
    return replace(
        kept,
        boxes=choice.boxes,
        pog=None,
        origin_m=choice.origin_m if is_stated else None,
        frames=choice.frames,
        find_ground=choice.find_ground,
        voxel_m=choice.voxel_m or "auto",
        roi_m=choice.roi_m,
        tolerance_pp=before.tolerance_pp if choice.voxel_m is None else None,
        rigs=(),
        score=ScoreOptions(),
    )
