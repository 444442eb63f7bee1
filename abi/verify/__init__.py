"""Verification of certificates in exact arithmetic, independent of the code that makes them."""
