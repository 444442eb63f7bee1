"""
A viser page of your own
========================

Show a box that can be dragged and the path around it, with nothing of the visualiser but `abi`.
"""

from __future__ import annotations

import sys
import threading

import numpy as np
import viser

import abi


def main(port: int = 8081, once: bool = False) -> int:
    """Serve until Ctrl+C, or plan ``once`` and stop; returns the port that was taken."""
    server = viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
    planner, scene = abi.Planner(), abi.load_scene("paper").replace(search={"taut": True})
    hand = server.scene.add_transform_controls("/box", position=(3, 3, 3), disable_rotations=True)
    server.scene.add_box("/box/body", dimensions=(2, 2, 2), color=(200, 90, 60))
    line = server.scene.add_line_segments("/curve", np.zeros((0, 2, 3)), (40, 170, 90))
    moved = threading.Event()
    hand.on_update(lambda _: moved.set())
    moved.set()
    while moved.wait():
        moved.clear()
        box = {"shape": "box", "size": [2, 2, 2], "position": [float(x) for x in hand.position]}
        plan = planner(scene.replace(obstacles=[box]))
        if plan.bspline is not None:
            points = plan.bspline.curve(np.linspace(0, 1, 200))
            line.points = np.stack([points[:-1], points[1:]], axis=1)
        line.visible = plan.bspline is not None
        print(f"box at {np.round(hand.position, 2)}: {plan.error or f'{plan.total_ms:.0f} ms'}")
        if once:
            break
    server.stop()
    return server.get_port()


if __name__ == "__main__":
    main(port=0 if "--once" in sys.argv else 8081, once="--once" in sys.argv)
