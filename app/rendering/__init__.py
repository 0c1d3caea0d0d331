"""Pictures for files: the scene of the window, drawn offscreen."""
