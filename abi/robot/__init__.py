"""Other people's arms: URDF files with their meshes, read strictly."""
