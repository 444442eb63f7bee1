"""What an arm must keep clear of, and its distances to it."""
