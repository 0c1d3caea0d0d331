"""What the window can do: one file for each kind of work; `riglens.app.window` says how features hook in."""
