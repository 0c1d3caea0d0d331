"""Guide, shortcuts and the command palette."""
