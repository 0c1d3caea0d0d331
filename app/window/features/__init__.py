"""What the window can do, one small class per file; `app.window` says how they hook in."""
