"""The paper beside the method: what it prints, and what we find."""
