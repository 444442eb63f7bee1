"""Strict reader of robots: URDF files with their meshes."""
