"""Panels: the controls of a tab, with what they read and write of a scene."""
