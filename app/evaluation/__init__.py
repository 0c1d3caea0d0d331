"""What is evaluated, and what the window shows of it: scenes, requests, scores, heatmaps."""
