"""Rigs in the formats of other programs: one file per format, behind `core.rig.formats.exchange`."""
