"""Joint positions over time, and the whole arm's clearance along them."""
