"""Files and links: scenes and meshes in, exports and reports out, undo and redo."""
