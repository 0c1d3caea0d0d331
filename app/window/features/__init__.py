"""What the window can do, one small class per file; `riglens.app.window` says how they hook in."""
