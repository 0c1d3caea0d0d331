"""Share terminal output between commands, studies and pictures: loading with progress, scores as text."""
