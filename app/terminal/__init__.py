"""What commands, studies and pictures share in the terminal: output, loading with progress, scores as text."""
