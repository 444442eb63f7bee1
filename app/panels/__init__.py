"""Panels: the controls of a tab, one class each, with what they read and write of a scene."""
