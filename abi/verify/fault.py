"""Fault that a certificate is found to have."""


class Fault(Exception):
    """Fault of a certificate that leaves its claim unproven."""
