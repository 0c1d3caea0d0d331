"""Codes shared by compiled and plain code; nothing here needs the compiler."""

from __future__ import annotations

LIDAR, CAMERA, LISTED = 0, 1, 2
"""Kinds of ray lattice; `lattice.py` defines their tables."""
NOTHING, GROUND, BODY = -1, -2, -3
"""Codes of what a ray hits, besides the number of a box."""
CLASS_COUNT = 3
VOXELS = 3
"""Columns of the sums of covered entropy: one for each of three classes, in units of 2^-32 nat, then the number of
voxels."""
PART_BITS = 2
MOST_PARTS = 1 << PART_BITS
"""Parts of the shape of a box; the lowest bits of a part's number say which."""
