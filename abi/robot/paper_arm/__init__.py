"""The paper's arm: its links, its capsules, its formulas and its drives."""
