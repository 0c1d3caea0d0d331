"""The inspector: every field of the selected sensor or of the vehicle."""
