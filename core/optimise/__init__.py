"""Proposed rigs: mounts on the car's skin, sets of them by search, an upper bound, and a guard against false gains."""
