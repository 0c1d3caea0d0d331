"""Show figures of objects: a table by class and ring, and a rose by sector."""
