"""What surrounds the car (paper, sections III-A and III-C): voxel grid, box data sets, probabilistic occupancy grid."""
