"""Stage 6: what an arm allows, and its motion along the curve.

``models.py`` is the table of the arms that the planner asks, by the same methods:
``paper_arm_model.py`` is the paper's, ``urdf_arm_model.py`` one that a URDF describes. ``world/``
is what an arm must keep clear of, ``exclusion/`` the mesh nodes and segments at which it does not,
``certificates/`` the proofs that it does, ``branch/`` the path on one elbow branch or from one
start pose, ``motion/`` joints over time, and ``joint_search/`` motions that are searched in the
space of the joints.
"""
