"""Whether tests try all that they can, as once a night, or what finds nearly all of it."""

from __future__ import annotations

import os

THOROUGH = os.environ.get("ABI_THOROUGH") == "1"
"""What ``make thorough`` sets: properties try ten times as many examples, the page all scenes."""
EXAMPLES = 1000 if THOROUGH else 100
"""Examples of a property that asks for no number of its own."""
