"""The planner: the stages in order, and the diagnosis of scenes without a plan."""
