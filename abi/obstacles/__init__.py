"""Obstacles: convex solids and triangle meshes, and their distances, one by one and as a set."""
