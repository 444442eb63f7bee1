"""Planner: runs the stages in order, and diagnoses scenes without a plan."""
