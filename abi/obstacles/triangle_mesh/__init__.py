"""Triangle meshes: reading and repair of files, and exact distances."""
