"""The 3D view: one drawing path for the window, offscreen pictures and tests."""
