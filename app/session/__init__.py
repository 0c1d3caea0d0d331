"""What is open: the rig with its history and file, and what is kept of it after a crash."""
