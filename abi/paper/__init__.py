"""The paper beside the method: its figures and ours."""
