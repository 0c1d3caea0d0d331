"""Detection range of the rig for one object: a table, and a chart of the chosen row."""
