"""Motions of an arm that are sought in the space of its joints, every edge of them proven."""
