"""Exit codes of the commands; 0 is success."""

from __future__ import annotations

BAD_INPUT = 2
INCOMPLETE = 3
"""No complete plan, or a proof that does not hold."""
UNDECIDED = 4
"""Not decided whether a motion touches something."""
