"""What is drawn of a frame in 3D and in the panels, a class each."""
