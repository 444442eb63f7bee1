"""Shapes in the form that viser draws: boxes, lines and triangles."""
