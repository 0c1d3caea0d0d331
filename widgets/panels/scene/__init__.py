"""Scene, look and voxel panels."""
