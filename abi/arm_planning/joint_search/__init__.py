"""Joint-space search for motions of an arm, every edge of them proven."""
