"""Count points, cells and pixels of a rig on objects, including occlusion by traffic."""
