"""Panels of the window: sensor tree, inspector, scene settings, scores; none of them knows the document."""
