"""Short ways past obstacles: proven bounds, and what pulls a path taut."""
