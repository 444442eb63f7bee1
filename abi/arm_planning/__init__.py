"""Stage 6: what an arm allows, and its motion along the curve.

``arm_model.py`` has the questions that the planner asks of any arm, and ``models.py`` the table of
the arms that answer: ``paper_arm_model.py`` for the paper's, ``urdf_arm_model.py`` for those that a
URDF describes. ``world/`` is what an arm must keep clear of, ``exclusion/`` the mesh nodes and
segments at which it does not, ``certificates/`` the proofs that it does, ``branch/`` the path on
one elbow branch or from one start pose, ``motion/`` joints over time, and ``joint_search/`` motions
that are searched in the space of the joints.
"""
