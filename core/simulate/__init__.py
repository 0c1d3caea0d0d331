"""Simulated sweeps, pictures and labels of a rig in traffic."""
