"""What the verifier finds wrong with a certificate."""

from __future__ import annotations


class Fault(Exception):
    """Fault of a certificate that leaves its claim unproven."""
