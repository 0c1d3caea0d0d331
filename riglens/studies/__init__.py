"""Studies for a reader: their tables in words, charts, pages."""
