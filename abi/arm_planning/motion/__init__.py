"""Joint positions over time, and how far the whole arm keeps clear meanwhile."""
