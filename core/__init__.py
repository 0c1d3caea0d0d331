"""The model and the mathematics of RigLens: no Qt, no VTK, no pyvista."""
