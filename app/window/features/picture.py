"""Pictures of the 3D view for reports: chosen in a dialog, drawn by a separate process, saved or copied."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

from PySide6.QtGui import QGuiApplication, QImage

from riglens.app.background.own_process import Tell
from riglens.app.background.picture_process import PictureJob, PictureMaker, drawn_set
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.files import beside_rig
from riglens.app.window.features.targets import Targets
from riglens.app.window.settings import Settings
from riglens.app.window.status import TOLD_MS
from riglens.app.window.workbench import Workbench
from riglens.core.figures.values import Values
from riglens.core.files import write_file
from riglens.evaluation.options import MAX_SIDE_PX, MIN_SIDE_PX
from riglens.rendering.picture import Findings, PictureWords, with_words
from riglens.widgets.panels.dialogs.picture import PictureDialog
from riglens.widgets.theme import LIGHT, palette

SET_PX, SET_SCALE = (800, 500), 2
Purpose = Literal["preview", "copy"] | Path


class Picture(Feature):
    """Dialog for pictures, one at a time; it draws the scene as it was when the dialog opened. Sets are drawn
    one at a time, too."""

    specs = (
        Spec(
            "screenshot", "Picture…", "Save the 3D view as a PNG picture, or copy it.", "F12", "screenshot",
            "file/export", "picture",
        ),
        Spec(
            "picture_set", "Picture set…",
            "Export the car from all sides, footprints, blind zones and camera views as PNG and SVG, with captions.",
            menu="file/export",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench, targets: Targets) -> None:
        super().__init__(bench)
        self._targets = targets
        self.dialog: PictureDialog | None = None
        self._options: dict[str, bool] = {}
        self._scale = 1
        self.maker = PictureMaker(self)
        self.bind(screenshot=self.open, picture_set=self.export_set)
        self.serve(self.maker, self._on_made, self._on_failed)
        bench.closing.connect(self._on_closed)

    def restore(self, settings: Settings) -> None:
        """Restore the options of an earlier session; the size is always that of the view."""
        found = settings.read("picture/options", {})
        self._options = {name: on for name, on in found.items() if isinstance(on, bool)}
        scale = settings.read("picture/scale", "")
        self._scale = int(scale) if scale in ("1", "2", "3", "4") else 1

    def keep(self, settings: Settings) -> None:
        """Write them for the next."""
        settings.write("picture/options", dict(self._options))
        settings.write("picture/scale", str(self._scale))

    def open(self) -> None:
        """Show the dialog, with the options of the last time."""
        if self.dialog is not None:
            self.dialog.raise_()
            return
        self._state = self.viewport.state
        result = self.bench.answers.result
        is_known = result is not None and result.request.rig == self.session.working_rig
        self._found = None
        if result is not None and is_known:
            self._found = Findings(
                result.request.rig, result.evaluation.scores, result.request.settings, result.scene.field,
                self.document.is_modified, self._counted(),
            )  # fmt: skip
        dialog = PictureDialog(
            self.viewport.picture_size,
            (MIN_SIDE_PX, MAX_SIDE_PX),
            self._state.palette is LIGHT,
            self.bench.window,
        )
        dialog.set_words_possible(is_known)
        dialog.recall(self._options, self._scale)
        dialog.changed.connect(self._preview)
        dialog.save_wanted.connect(self._save)
        dialog.copy_wanted.connect(lambda: self._draw("copy", dialog.choice.scale))
        dialog.busy.cancelled.connect(self._cancel)
        dialog.finished.connect(lambda _: self._on_closed())
        self.dialog = dialog
        dialog.open()
        self._preview()

    def export_set(self) -> None:
        """Ask for a folder, and write the set of pictures into it."""
        suggestion = beside_rig(self.document, f"{self.document.rig.name} pictures", "")
        folder = self.bench.dialogs.export_rig(self.bench.window, suggestion, "the picture set", True)
        if folder is None:
            return
        state = self.viewport.state

        def write(tell: Tell) -> int:
            return drawn_set(state, folder, SET_PX, SET_SCALE, tell)

        self.bench.tasks.run(
            "Picture set",
            write,
            lambda count: self.bench.status.showMessage(
                f"Picture set: {count} files written to {folder}", TOLD_MS
            ),
            ended=lambda: self.bench.actions.allow("picture_set"),
        )
        self.bench.actions.allow("picture_set", "A picture set is being drawn.")

    def _counted(self) -> Values:
        """Return the figures of objects of the rig, once all frames are counted."""
        answer = self._targets.answer
        return answer.figures if answer is not None and self._targets.is_current else {}

    def _preview(self) -> None:
        """Draw the picture as large as the preview is; it is drawn whole once it is saved or copied."""
        if self.dialog is not None:
            room, size = self.dialog.preview.room_px, self.dialog.choice.size_px
            self._draw("preview", min(1.0, room[0] / size[0], room[1] / size[1]))

    def _save(self) -> None:
        suggestion = beside_rig(self.document, self.document.rig.name, ".png")
        path = self.bench.dialogs.save_picture(self.dialog or self.bench.window, suggestion)
        if path is not None and self.dialog is not None:
            self._draw(path, self.dialog.choice.scale)

    def _draw(self, purpose: Purpose, scale: float) -> None:
        """Request a picture."""
        if self.dialog is None:
            return
        choice = self.dialog.choice
        state = replace(self._state, palette=palette(not choice.light), show_ground=choice.ground)
        words = PictureWords(choice.legend, choice.title, choice.scores)
        state = with_words(state, words, self._found)
        job = PictureJob(state, choice.size_px, scale, choice.transparent, purpose)
        self.dialog.set_busy("drawing…")
        self.maker.ask(job)

    def _cancel(self) -> None:
        """Give up the picture that is being drawn; the dialog stays."""
        self.maker.cancel()
        if self.dialog is not None:
            self.dialog.set_busy("")
            self.dialog.set_done("cancelled")

    def _on_made(self, job: PictureJob, png: bytes) -> None:
        if self.dialog is None:
            return
        self.dialog.set_busy("")
        purpose = job.purpose
        if purpose == "preview":
            self.dialog.preview.show_png(png)
        elif purpose == "copy":
            QGuiApplication.clipboard().setImage(QImage.fromData(png))
            self.dialog.set_done("copied")
        elif isinstance(purpose, Path):
            self.bench.guarded(write_file)(purpose, png)
            self.dialog.accept()

    def _on_failed(self, problem: str) -> None:
        if self.dialog is not None:
            self.dialog.set_busy("")
        self.bench.report_error(f"The picture could not be drawn: {problem}")

    def _on_closed(self) -> None:
        self.maker.cancel()
        dialog, self.dialog = self.dialog, None
        if dialog is not None:
            self._options, self._scale = dialog.options, dialog.choice.scale
            dialog.deleteLater()
