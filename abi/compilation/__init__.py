"""What kernels need of the compiler: stamps of their sources, and arguments they borrow."""
