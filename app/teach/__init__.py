"""Teaching: lessons with their files, steps and measures; challenges, and classes."""
