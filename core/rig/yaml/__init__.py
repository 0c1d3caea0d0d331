"""Rig files in YAML, version 1: read with one-line errors, edited in place, written."""
