"""Voxel sets as bits, entropies by code, coverage updated in integers, and the filling of a POG."""
