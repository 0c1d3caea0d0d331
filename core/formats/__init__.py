"""Rigs in the formats of other programs: one file per format, behind `riglens.core.formats.exchange`."""
