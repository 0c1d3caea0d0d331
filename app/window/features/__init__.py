"""Features of the window: one file for each kind of work; `riglens.app.window` documents how features hook in."""
