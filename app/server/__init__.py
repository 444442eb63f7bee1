"""The web server: its address, its worker processes, and what it loads in advance."""
