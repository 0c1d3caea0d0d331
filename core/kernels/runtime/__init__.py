"""Compilation, its cache, shared work and the numbers by which kernels name things."""
