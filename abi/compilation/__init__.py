"""Additions to the compiler for kernels: stamps of their sources, and borrowed arguments."""
