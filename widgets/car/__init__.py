"""The ego car as it is drawn: parametric bodies, wheels, materials."""
