"""The scores of the rig, as a table with their recent history."""
