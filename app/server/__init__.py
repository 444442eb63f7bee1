"""The web server: its address, its worker processes, and what it loads before it is asked."""
