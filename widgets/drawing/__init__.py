"""What everything in the 3D view is drawn with: camera, renderers and lights, surfaces, actors, text."""
