"""The heatmap: its cells, scale, colours and legend."""
