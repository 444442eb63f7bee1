"""Start, goal and obstacles, as numbers and under gizmos in the scene."""
