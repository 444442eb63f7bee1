"""Planner: the stages in order, and why there is no plan."""
