"""Model the car's surroundings (paper, sections III-A and III-C): voxel grid, box data sets, probabilistic occupancy
grid."""
