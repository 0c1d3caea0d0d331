"""Does a score predict detection? Sweeps of rigs, detectors trained on them, average precision with intervals."""
