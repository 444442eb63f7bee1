"""Generated questions: templates whose answers come from the algorithms, for any seed."""
