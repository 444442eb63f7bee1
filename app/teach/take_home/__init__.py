"""Export of lessons: as a single page, and as a package for learning platforms."""
