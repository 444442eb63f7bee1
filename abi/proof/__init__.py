"""Certificates that a curve keeps clear, and the checker that re-does them in rationals."""
