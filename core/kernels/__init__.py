"""Numba kernels: ray lattices, traversal, POG filling and sums. They import numpy, numba and each other only."""
