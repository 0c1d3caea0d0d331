"""Counts for a safety review: blind columns, overlap of sensors, redundancy."""
