"""The scores of the rig, as a table."""
