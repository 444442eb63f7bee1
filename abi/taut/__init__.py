"""Stage 3½: path pulled taut, free of the mesh's directions, and the optimum beside it."""
