"""Camera: views that show a plan as large as possible."""
