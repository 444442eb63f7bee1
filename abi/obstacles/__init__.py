"""Obstacles: convex primitives and triangle meshes, and their distances, singly and as a set."""
