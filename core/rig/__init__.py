"""Sensors, rigs, their YAML files and the built-in presets."""
