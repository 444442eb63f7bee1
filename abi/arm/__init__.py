"""Stage 6: the arm, its inverse kinematics, and its motion along the curve."""
