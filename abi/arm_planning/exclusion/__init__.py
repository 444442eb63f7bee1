"""Mesh nodes, segments and regions at which an arm touches something."""
