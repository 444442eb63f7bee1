"""Layers: what is drawn of a frame in the scene and in the panels."""
