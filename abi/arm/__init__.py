"""Stage 6: the arm, its inverse kinematics, and its motion along the curve.

``arm_model.py`` has the questions that the planner asks of any arm, ``any_arm.py`` those of all
other code, and ``models.py`` the table of the arms that answer. The paper's arm: ``abi_model.py``,
``arm.py``, ``inverse_kinematics.py`` (by formulas), ``trajectory.py``, ``arm_sight.py``,
``arm_certificate.py``. A URDF arm: ``urdf_model.py``, ``urdf_arm.py``, ``chain.py`` and
``follow_path_kernels.py`` (damped least squares), ``urdf_motion.py``, and all of ``chain_*.py``.
"""
