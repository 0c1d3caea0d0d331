"""The ego car: meshes of its body, and where a sensor sits on a surface."""
