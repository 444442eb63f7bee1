"""Guard between page and network, and reader of files from outside."""
