"""Footprints: what a camera resolves, and a radar or ultrasonic sensor reaches, on flat ground."""
