"""Display of a plan in a notebook's cell or in a browser tab."""

from __future__ import annotations

import html
import sys
import tempfile
import warnings
import webbrowser
from pathlib import Path

from abi.browser import missing_browser
from abi.export import html_page
from abi.planner.own_search import OwnSearch, plan_with
from abi.planner.plan import Plan, require_plan

HEIGHT = 560
"""Height of the frame in a notebook, [px]."""


def show(plan: Plan, search: OwnSearch | None = None) -> object:
    """Show a plan: in a notebook as the cell's value, elsewhere in a browser tab.

    The page is that of ``abi export --to plan.html`` and plays without a server.

    Args:
        plan: a plan; it may be incomplete, but must have a mesh.
        search: of your own; it gets the plan's graph and returns the nodes of its path, or these
            and the nodes that it has expanded, in their order. The later stages are planned again
            for its path, for the tool alone, and the page has its steps.

    Returns:
        In a notebook the page in a frame, as IPython draws it; its script cannot reach the
        notebook's. Elsewhere None.

    Raises:
        AbiError: no plan, or one without a mesh.
        ArgumentError: what ``search`` returns is no path of the graph.
    """
    require_plan(plan)
    if search is not None:
        plan = plan_with(plan.scene, search)
    page = html_page.write(plan, "plan.html").decode()
    if "ipykernel" in sys.modules:
        from IPython.display import IFrame  # only there it is sure to be installed

        extras = ['sandbox="allow-scripts"', f'srcdoc="{html.escape(page)}"']
        return IFrame("about:blank", "100%", HEIGHT, extras=extras)
    file = Path(tempfile.mkdtemp(prefix="abi-")) / "plan.html"
    file.write_text(page, encoding="utf-8")
    if reason := missing_browser():
        warnings.warn(f"{reason} Open {file} in one that runs WebGL.", stacklevel=2)
    else:
        webbrowser.open(file.as_uri())
    return None
