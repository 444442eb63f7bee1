"""What the tabs of one process share: its memory, its turns, its log and its figures."""
