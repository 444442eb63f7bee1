"""Verification of certificates in exact numbers; knows nothing of how they are made."""
