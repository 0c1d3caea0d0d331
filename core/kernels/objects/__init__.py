"""Find the first hits of rays on objects, counted, painted or swept."""
