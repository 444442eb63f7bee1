"""The search theatre: a search stopped at a step, in words and numbers."""
