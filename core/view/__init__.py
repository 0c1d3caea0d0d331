"""What a single sensor sees of one frame: pictures for a person, beside the metric."""
