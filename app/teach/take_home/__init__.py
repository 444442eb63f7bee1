"""Lessons to take home: as one page, and as a package for a learning platform."""
