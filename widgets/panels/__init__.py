"""Panels of the window: they show given data and emit the user's requests; none knows the document."""
