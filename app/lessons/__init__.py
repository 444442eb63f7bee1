"""Lessons: their files, steps, checks and measures."""
