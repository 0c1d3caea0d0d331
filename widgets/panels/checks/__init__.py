"""The checks of a rig, one page each."""
