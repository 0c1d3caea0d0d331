"""The window: small features over one session, one view and one background thread.

`main_window.MainWindow` makes a `Workbench` (workbench.py), which is all that a feature may use, and has build.py
build every feature on it. A feature is one class under `features/`:

    class Mirror(Feature):
        specs = (Spec("mirror", "Mirror", "Add the mirror image of the selected sensor", "M",
                      menu="sensor/edit", tool="place"),)

        def __init__(self, bench: Workbench, files: Files) -> None:
            super().__init__(bench)                       # makes the actions and puts them into menu and toolbar
            self.bind(mirror=self.mirror)                 # says what each action does
            self.dock = bench.docks.add("Mirror", Panel(), area, beside="Inspector")    # with an entry under View
            self.document.selection_changed.connect(self._update)    # hears of what it depends on, and no more
            self._update()                                # shows what is so at first

It is built by `build.Features`, where it gets the features that it needs as arguments. What is asked now
(metric, heatmap, baseline, picked voxel, map, traffic) is read from `self.session`, changed by its setters, and told
by its signals; what was answered is in `bench.answers`. Edits of the rig go to `self.document`, through
`bench.guarded(...)`, which turns an InputError into a message. What the view shows is changed by
`viewport.show_state(replace(viewport.state, ...))`. Long work: `bench.tasks.run`. Sections of menus and toolbar:
places.py. `remember` keeps a choice for the next session; `mouse` adds lines to the sheet of shortcuts.

A feature knows neither the main window nor the builder, and an import contract says so.
"""
