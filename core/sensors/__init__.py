"""Kinds of sensor, one file each: fields, rays, placement and hits on objects."""
