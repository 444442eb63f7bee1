"""Stages 4 and 5: B-spline, quadratic, and the motion in three phases along them."""
