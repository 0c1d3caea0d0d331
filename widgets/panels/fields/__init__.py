"""Fields that hold a value with a unit, and forms made of them."""
