"""Poses of scene nodes that viser 1.1.1 does not send.

viser sends a pose only where it differs from the last one it knows of, or from that of a new node.
The page may have another: a node that is removed and added again under its name before either is
sent keeps its pose there, and what ``assets/page/page.js`` moves is where that has put it.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import viser
from viser import _messages, _scene_handles

assert viser.__version__ == "1.1.1", "app/ui/node_poses.py uses private names of viser 1.1.1"

_make: Any = _scene_handles.SceneNodeHandle._make.__func__  # type: ignore[attr-defined]


def install() -> None:
    """Send every new node's pose from now on; one call suffices."""
    handle: Any = _scene_handles.SceneNodeHandle
    handle._make = classmethod(_make_posed)


def forget(node: viser.SceneNodeHandle) -> None:
    """Force the next position and orientation of a node to be sent.

    Until they are set the node has none.
    """
    node._impl.position = np.full(3, np.nan)
    node._impl.wxyz = np.full(4, np.nan)


@functools.wraps(_make)
def _make_posed(cls: Any, api: Any, *arguments: Any, **named: Any) -> Any:
    """Add a node as viser does, and send its pose."""
    node = _make(cls, api, *arguments, **named)
    position, wxyz = node._impl.position.tolist(), node._impl.wxyz.tolist()
    api._queue_scene_message(_messages.SetPositionMessage(node.name, tuple(position)))
    api._queue_scene_message(_messages.SetOrientationMessage(node.name, tuple(wxyz)))
    return node
