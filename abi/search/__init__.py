"""Stages 2 and 3: graph, and A*, Dijkstra and Bellman-Ford on it."""
