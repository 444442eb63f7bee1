"""Inputs of the method's stages, and studies of them."""
