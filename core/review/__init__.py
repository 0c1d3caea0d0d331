"""Review the safety of a rig: blind zones, redundancy, tolerances, mounts, and requirements on all of them."""
