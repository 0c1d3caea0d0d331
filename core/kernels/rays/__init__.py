"""Ray lattices, exact predicates and single rays through the grid: walked, in strides, or approximately."""
