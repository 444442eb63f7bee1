"""The page: its layout, its style, its words and numbers, and how viser is told of them."""
