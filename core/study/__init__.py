"""Studies over many rigs and settings: the paper's tables, speed against accuracy, stability."""
