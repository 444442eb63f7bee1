"""Proofs that a motion which anybody planned keeps a robot clear, or where it does not."""
