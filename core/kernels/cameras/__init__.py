"""Tilted and distorted cameras: which voxels a lattice of pixels hits."""
