"""What the rig gets onto road users: a table by class and ring, and a rose by sector."""
