"""The handles that move and turn a sensor: pure maths, and the actors that show them."""
