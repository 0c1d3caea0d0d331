"""Pictures for files, drawn offscreen by the scene of the window; display and system libraries for drawing."""
