"""Controls of a tab, a class each: what they read and write of a scene."""
