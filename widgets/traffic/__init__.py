"""One frame of the traffic in the 3D view: objects as solid shapes, and the points of the rig's LiDARs."""
