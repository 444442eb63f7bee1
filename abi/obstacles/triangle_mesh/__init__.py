"""Triangle meshes: files read and repaired, and exact distances to them."""
