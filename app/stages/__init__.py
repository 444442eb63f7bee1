"""The stages as the page shows them: one table, and the results and numbers in it."""
