"""Intersect rays with the car's own body, triangle by triangle."""
