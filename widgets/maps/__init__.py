"""Flat pictures next to the 3D view: the map from above, camera images, LiDAR range images."""
