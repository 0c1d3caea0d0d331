"""Guide, tips, shortcuts and the command palette."""
