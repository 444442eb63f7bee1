"""Explanations of a plan: why there is none, what would help, and what its motion lacks."""
