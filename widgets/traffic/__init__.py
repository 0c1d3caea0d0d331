"""One frame of the traffic in the 3D view: road users as solid shapes, and the points of the rig's LiDARs."""
