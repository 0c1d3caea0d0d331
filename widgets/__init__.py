"""Widgets of the window: the 3D view, gizmos, panels, maps. May import core, never app."""
