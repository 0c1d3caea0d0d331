"""What surrounds the car: voxel grid, box data sets and the probabilistic occupancy grid (POG)."""
