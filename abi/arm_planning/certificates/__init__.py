"""Proofs that an arm keeps clear along a curve or a path of its joints."""
