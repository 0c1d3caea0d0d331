"""Background work of the window: one thread for the engine, others for pictures and long jobs."""
