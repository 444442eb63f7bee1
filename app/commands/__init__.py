"""Commands of ``abi``, a file each."""
