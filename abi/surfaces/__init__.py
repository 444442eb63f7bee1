"""Obstacles given as triangle meshes: files, repair, distance."""
