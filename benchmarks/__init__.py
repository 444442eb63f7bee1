"""What the claims of speed and quality rest on: ``abi bench``, or each part by itself."""
