"""Arms: URDF files, chains of joints, bodies of links, inverse kinematics, and the paper's arm.

``any_arm.py`` names both kinds of arms. ``urdf/`` reads robots strictly, ``kinematics/`` has the
chain from base to tip, its inverse kinematics by damped least squares and its torques, ``bodies/``
the capsules around links; ``urdf_arm.py`` is the arm made of these. ``paper_arm/`` is the paper's,
with inverse kinematics by formulas.
"""
