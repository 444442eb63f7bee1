"""Readers of mesh files, one module for each format; they get bytes and open nothing."""
