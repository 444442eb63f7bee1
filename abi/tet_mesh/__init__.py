"""Stage 1: tetrahedral mesh of the workspace, without the nodes in obstacles."""
