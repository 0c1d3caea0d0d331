"""Sensors in lists: those of the rig, and the models of the library."""
