"""Stage 6: arm, its inverse kinematics, and its motion along the curve."""
