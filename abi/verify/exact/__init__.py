"""Curves, solids and arms in exact rational numbers, without the code that plans."""
