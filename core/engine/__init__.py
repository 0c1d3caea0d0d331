"""Incremental evaluation of a rig: per-sensor contributions, recast only where something moved."""
