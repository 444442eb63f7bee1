"""Values that several tabs share: plans, diagnoses, texts and meshes, made once."""
