"""What people look at, beside the metric: what a sensor sees of one frame, the scene from above and in cells."""
