"""Questions without end: templates whose answers come from the algorithms, for any seed."""
