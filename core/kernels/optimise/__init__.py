"""Compiled loops over what candidate sensors cover."""
