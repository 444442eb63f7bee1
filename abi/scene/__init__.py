"""Scene: all that the method is told, checked, with its file."""
