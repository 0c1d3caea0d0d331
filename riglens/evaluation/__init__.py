"""Evaluate rigs and prepare the results for display: scenes, requests, scores, heatmaps."""
