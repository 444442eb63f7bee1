"""One browser tab: its session, its thread, its view and its limits."""
