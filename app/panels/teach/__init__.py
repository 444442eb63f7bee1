"""Lessons, lectures, classes, the search theatre and the tour."""
