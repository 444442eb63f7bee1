"""The scene, the checked input of the method, and its file."""
