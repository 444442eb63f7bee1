"""Grounds for the claims of speed and quality: ``abi bench``, or each part by itself."""
