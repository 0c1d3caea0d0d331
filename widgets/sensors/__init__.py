"""Sensors and their rays as they are drawn."""
