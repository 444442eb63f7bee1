"""The verifier's finding against a certificate."""

from __future__ import annotations


class Fault(Exception):
    """Fault of a certificate that leaves its claim unproven."""
