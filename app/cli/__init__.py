"""Commands of ``abi``, one file each."""
