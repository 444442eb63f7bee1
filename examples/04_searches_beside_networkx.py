"""
Searches beside networkx
========================

Hand the graph of a plan to networkx and let its searches confirm what ours found.
"""

from __future__ import annotations

import networkx

import abi

plan = abi.plan(abi.load_scene("two-boxes"))
graph = plan.graph
assert graph is not None

print("search         length  hops  nodes expanded")
for found in plan.searches:
    print(f"{found.algorithm:12}  {found.length:7.4f}  {found.hops:4}  {found.expanded:6}")

# %%
# The nodes are numbered as in the plan, so that paths can be compared node by node.
theirs = graph.to_networkx()
print(f"networkx has {len(theirs)} nodes and {theirs.size():.0f} edges")

ends = graph.start, graph.goal
by_length = networkx.dijkstra_path_length(theirs, *ends, weight="length")
by_hops = networkx.shortest_path_length(theirs, *ends)
print(f"networkx: {by_length:.4f} by length, {by_hops} hops at least")
assert all(abs(found.length - by_length) < 1e-9 for found in plan.searches)

# %%
# Any other algorithm of networkx can be tried on the same graph. Betweenness says through which
# nodes many shortest paths pass.
crowded = networkx.betweenness_centrality(theirs, k=20, weight="length", seed=1)
node = max(crowded, key=lambda one: crowded[one])
x, y, z = graph.points[node].tolist()
print(f"the busiest node is {node} at ({x:.2f}, {y:.2f}, {z:.2f})")
