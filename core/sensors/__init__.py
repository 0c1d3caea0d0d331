"""Kinds of sensor, each in a file of its own: fields, rays, how it is placed and what it gets from an object."""
