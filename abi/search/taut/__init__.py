"""Stage 3½: the path pulled taut, and the lower bound that its length is compared with."""
