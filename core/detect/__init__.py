"""A small detector on simulated sweeps, and how well it detects: average precision as nuScenes has it."""
