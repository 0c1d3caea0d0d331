"""The window: a composition of small features over one document, one viewport and one background thread.

A feature is one small class in a file of its own under `features/`, listed in `main_window.FEATURES`:

    class Mirror(Feature):
        specs = (Spec("mirror", "Mirror", "Add the mirror image of the selected sensor", "M",
                      menu="sensor/edit", tool="sensor"),)

        def __init__(self, window: MainWindow) -> None:
            super().__init__(window)                      # makes the actions and puts them into menu and toolbar
            self.bind(mirror=self.mirror)                 # what each action does
            self.dock = window.add_dock("Mirror", Panel(), area, beside="Inspector")    # entry under View for free
            window.rig_shown.connect(self._follow)        # see the signals of MainWindow

Sections of menus and toolbar: `places.py`. Long work: `window.tasks.run`. `restore` and `keep` carry
choices to the next session; `mouse` adds lines to the sheet of shortcuts. Edits go through `window.guarded(...)`,
which turns an InputError into a message. One feature reaches another by `window.feature(Files)`. MainWindow itself
knows no single feature's work.
"""

from riglens.app.window.main_window import MainWindow
from riglens.app.window.start import open_window

__all__ = ["MainWindow", "open_window"]
