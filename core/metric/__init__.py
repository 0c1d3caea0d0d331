"""The metric of the paper: entropies, S-MIG, S-MS and `seen`, typed and validated."""
