"""State of a tab: its frame, and the text from which it is restored."""
