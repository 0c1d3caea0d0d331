"""Sensing: the rays of a sensor, from its description alone (paper, section III-B)."""
