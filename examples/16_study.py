"""
A study of many scenes
======================

Plan random scenes under several settings at once and look at what they have in common.
"""

from __future__ import annotations

from abi_sweep.study import Study
from abi_sweep.sweep import sweep
from abi_sweep.table import summary

study = Study.from_dict(
    {
        "version": 1,
        "scenes": [{"boxes": 4, "seeds": 6}],
        "vary": {
            "mesh.lattice": ["bcc", "kuhn"],
            "mesh.pitch": [1.2, 0.7],
            "arm.avoid": [False],
        },
    }
)
rows = sweep(study)
print(f"{study.size} plans, of each {len(rows[0])} columns")

# %%
# One line per combination, with medians over the scenes. ``abi sweep`` does the same for a study
# file, on all cores, and draws it.
for line in summary(rows, study.axes):
    gap, taut = line["path gap [%]"], line["taut gap [%]"]
    setting = f"{line['mesh.lattice']:5} {line['mesh.pitch']}"
    print(f"{setting}: path {gap:5.2f} % longer than the bound, taut {taut:5.2f} %")
