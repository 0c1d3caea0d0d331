"""Several rigs side by side, as a table and as bars."""
