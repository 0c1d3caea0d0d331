"""Many rigs that differ in some fields: designs, figures of each rig, and one table of all."""
