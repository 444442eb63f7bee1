"""Clearance of curves, measured and proven."""
