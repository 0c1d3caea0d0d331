"""Hold the open document: the rig with its history and file, and its autosave."""
