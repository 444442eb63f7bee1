"""Bodies of an arm's links: solids that are drawn, and capsules that contain them."""
