"""Figures of a rig: each number about a rig that the program shows, defined once."""
