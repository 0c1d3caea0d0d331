"""Upright sensors: all rays that share a vertical plane walk through the grid together."""
