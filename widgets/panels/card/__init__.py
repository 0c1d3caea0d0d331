"""Up to which distance the rig gets enough onto one road user: a table, and a chart of the chosen row."""
