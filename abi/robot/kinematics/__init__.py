"""Chain of a robot's joints: poses, inverse kinematics and torques."""
