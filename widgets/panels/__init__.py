"""Panels of the window: they show what they are told and signal what the user wants; none knows the document."""
