"""Drawing tools of the 3D view: camera, renderers and lights, surfaces, actors, text."""
