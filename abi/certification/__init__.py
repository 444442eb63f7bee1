"""Proofs that a motion from any planner keeps a robot clear, or where it does not."""
