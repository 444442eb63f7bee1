"""Paths on one branch: an elbow of the paper's arm, or a start pose of another."""
