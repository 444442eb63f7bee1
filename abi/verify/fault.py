"""Fault of a certificate."""


class Fault(Exception):
    """Fault of a certificate that leaves its claim unproven."""
