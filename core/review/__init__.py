"""What a safety review asks of a rig: blind zones, redundancy, tolerances, mounts, and requirements on all of them."""
