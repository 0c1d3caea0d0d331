"""What a person sees and touches: the 3D view, gizmos, panels, maps. May import core, never app."""
