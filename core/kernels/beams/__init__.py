"""Tilted spinning LiDARs: the cones of dense beams over the grid, tile by tile."""
