"""The metric of the paper (section III-D): entropies of the POG, S-MIG, S-MS and `seen`, typed and validated."""
