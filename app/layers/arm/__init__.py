"""What is drawn of the arm: its links, its other poses and its regions."""
