"""Compute views of the data apart from the metric: a sensor's view of one frame, the scene from above and in cells."""
