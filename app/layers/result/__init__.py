"""Numbers, tables and plots of a plan."""
