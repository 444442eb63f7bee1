"""Display of a plan in a notebook's cell or in a browser tab."""

from __future__ import annotations

import html
import sys
import tempfile
import warnings
import webbrowser
from dataclasses import dataclass
from pathlib import Path

from abi.arrays import ShortRepr
from abi.browser import missing_browser
from abi.export import html_page
from abi.planner.own_search import OwnSearch, plan_with
from abi.planner.plan import Plan, require_plan

HEIGHT = 560
"""Height of the frame in a notebook, [px]."""


@dataclass(frozen=True, repr=False)
class ShownPlan(ShortRepr):
    """The page of a plan, which a notebook draws as a cell's value.

    Attributes:
        page: the whole HTML file.
    """

    page: str

    def _repr_html_(self) -> str:
        """The page in a frame of its own, whose script cannot reach the notebook's."""
        return (
            f'<iframe srcdoc="{html.escape(self.page)}" sandbox="allow-scripts" '
            f'style="width:100%;height:{HEIGHT}px;border:0"></iframe>'
        )


def show(plan: Plan, search: OwnSearch | None = None) -> ShownPlan:
    """Show a plan: in a notebook as the cell's value, elsewhere in a browser tab.

    The page is that of ``abi export --to plan.html`` and plays without a server.

    Args:
        plan: a plan; it may be incomplete, but must have a mesh.
        search: of your own; it gets the plan's graph and returns the nodes of its path, or these
            and the nodes that it has expanded, in their order. The later stages are planned again
            for its path, for the tool alone, and the page has its steps.

    Returns:
        An object with the HTML text in ``page``, which a notebook draws.

    Raises:
        AbiError: no plan, or one without a mesh.
        ArgumentError: what ``search`` returns is no path of the graph.
    """
    require_plan(plan)
    if search is not None:
        plan = plan_with(plan.scene, search)
    page = html_page.write(plan, "plan.html").decode()
    if "ipykernel" not in sys.modules:
        folder = Path(tempfile.mkdtemp(prefix="abi-"))
        file = folder / "plan.html"
        file.write_text(page, encoding="utf-8")
        if reason := missing_browser():
            warnings.warn(f"{reason} Open {file} in one that runs WebGL.", stacklevel=2)
        else:
            webbrowser.open(file.as_uri())
    return ShownPlan(page)
