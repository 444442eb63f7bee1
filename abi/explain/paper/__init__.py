"""Comparison of the paper's printed numbers with ours."""
