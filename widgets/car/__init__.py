"""Drawing of the ego car: parametric bodies, wheels, materials."""
