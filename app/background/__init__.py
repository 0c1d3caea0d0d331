"""Work beside the interface: one thread for the engine, others for pictures and long jobs."""
