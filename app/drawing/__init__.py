"""Shapes as what viser draws: boxes, lines and triangles."""
