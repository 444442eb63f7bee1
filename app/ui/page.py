"""Access to the parts of the page for which viser 1.1.1 has no public interface."""

from __future__ import annotations

import asyncio
import functools
import json
import re
import time
import uuid as uuids
import weakref
from collections.abc import Callable, MutableMapping, Sequence
from concurrent.futures import Future
from types import SimpleNamespace
from typing import Any, Literal, TypeVar

import numpy as np
import viser
from numpy.typing import NDArray
from viser import _messages
from viser._threadpool_exceptions import print_awaited_callback_error

from abi import assets
from app.ui import node_poses, viser_shortcuts

assert viser.__version__ == "1.1.1", "app/ui/page.py uses private names of viser 1.1.1"

SILENCE = 60.0
"""Seconds without a new part after which an upload counts as lost."""
LIFETIME = 900.0
"""Seconds within which an upload must be complete: 50 MB over a slow line."""

Function = Literal[
    "clock",
    "copyLink",
    "follow",
    "hearFiles",
    "lecture",
    "next",
    "openTab",
    "play",
    "pointOut",
    "remember",
    "rememberLessons",
    "report",
    "seek",
    "show",
    "showStage",
    "showNodes",
    "stand",
    "watch",
]
"""Functions of the page in ``assets/page``."""

_SLOTS: dict[Function, str] = {
    "clock": "clock",
    "follow": "bodies",
    "lecture": "lecture",
    "play": "motion",
    "pointOut": "spotlight",
    "remember": "remember",
    "seek": "moment",
    "showNodes": "nodes",
    "stand": "end of motion",
}
"""Slots by function: a call replaces an unsent one of its slot, ``show`` only one for its part.

A motion does not replace the end of the previous one, which precedes the nodes of another arm."""
_Store = TypeVar("_Store", bound=MutableMapping[int, bytes])
_COMMENT = re.compile(r"(//.*|/\*[^*]*\*/)?")

viser_shortcuts.install()
node_poses.install()


def _call_at_once(call: Callable[..., Any], /, *args: Any, **named: Any) -> Future[Any]:
    """Run a callback as an executor does, but at once: it only wakes a worker, in its order."""
    done: Future[Any] = Future()
    try:
        done.set_result(call(*args, **named))
    except Exception as error:
        done.set_exception(error)
    return done


def set_on_loop_only(event: asyncio.Event) -> None:
    """Have an event set only in the thread of the connections.

    viser sets its events at once in any thread, and then has that thread set them. The first may
    come between a waiter's look at the event and its place among those who are woken; the second
    changes nothing then, and the tab would never hear of anything again.
    """
    event.set = functools.partial(_set_on_loop, event.set)  # type: ignore[method-assign]


def _set_on_loop(set_event: Callable[[], None]) -> None:
    if asyncio._get_running_loop() is not None:
        set_event()


def install(client: viser.ClientHandle) -> None:
    """Set the tab's title and install the functions for :func:`call`."""
    buffer = client._websock_connection.get_message_buffer()
    set_on_loop_only(buffer.message_event)
    executor: Any = SimpleNamespace(submit=_call_at_once)
    client.gui._thread_executor = client.scene._thread_executor = executor
    _run(client, 'document.title = "ABI visualiser"')
    _run(client, _script())


def call(client: viser.ClientHandle, function: Function, *arguments: object) -> None:
    """Call a function of ``assets/page`` in the tab; the scripts document them.

    Args:
        client: the tab.
        function: name in ``abi``.
        arguments: plain data.
    """
    slot = f"show {arguments[0]}" if function == "show" else _SLOTS.get(function, "")
    _run(client, f"abi.{function}({', '.join(map(json.dumps, arguments))})", slot)


def uuid(
    widget: viser.GuiInputHandle[Any] | viser.GuiButtonHandle | viser.GuiUploadButtonHandle,
) -> str:
    """Identifier by which the page sets a widget."""
    return widget._impl.uuid


def on_arrival(
    gui: viser.GuiApi,
    button: viser.GuiUploadButtonHandle,
    tell: Callable[[str, float | None], None],
    store: Callable[[], _Store],
) -> Callable[[], _Store | None]:
    """Have ``tell`` called with the name and the received part of a file for ``button``.

    viser itself calls back once the whole file is there. These calls come from the first word of a
    file until then, and in the thread of the connections; with None for the part when nothing more
    of it has come for ``SILENCE`` seconds. Parts of a file by their numbers are put into what
    ``store`` makes, and dropped after ``LIFETIME``, or once the tab is gone.

    Returns:
        A function for viser's call: the file that is there, or None for one without a byte.
    """
    known: Any = gui._current_file_upload_states
    # viser has the files, and drops those of a tab that is gone
    files = weakref.WeakValueDictionary[str, _Store]()
    silence: asyncio.TimerHandle | None = None

    def give_up(transfer: str) -> None:
        if transfer in known:  # the tab is still there
            tell(known[transfer]["filename"], None)

    def drop(transfer: str, file: Callable[[], _Store | None]) -> None:
        """Drop an overdue file."""
        if transfer in known and known[transfer]["parts"] is file():
            give_up(transfer)
            del known[transfer]

    def hear(_: int, message: Any) -> None:
        nonlocal silence
        if message.source_component_uuid != uuid(button):
            return
        if silence is not None:
            silence.cancel()
        # viser has heard it before: of a file that is there it knows no more
        transfer, loop = message.transfer_uuid, asyncio.get_running_loop()
        if (state := known.get(transfer)) is None:
            return
        if transfer not in files:
            files[transfer] = state["parts"] = file = store()
            loop.call_later(LIFETIME, drop, transfer, weakref.ref(file))
        silence = loop.call_later(SILENCE, give_up, transfer)
        tell(state["filename"], state["transferred_bytes"] / max(state["total_bytes"], 1))

    def take() -> _Store | None:
        whole = next((name for name in files if name not in known), None)
        return None if whole is None else files.pop(whole, None)

    for message in (_messages.FileTransferStartUpload, _messages.FileTransferPart):
        gui._websock_interface.register_handler(message, hear)
    return take


def forget_file(button: viser.GuiUploadButtonHandle) -> None:
    """Release the content of the last upload, which viser would keep until the next one."""
    button._impl.value = viser.UploadedFile("", b"")


def disable_sharing(server: viser.ViserServer) -> None:
    """Disable viser's public tunnel, which any visitor could open."""
    handlers = server._websock_server._incoming_handlers
    for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        handlers.pop(message, None)


def run_on_loop(server: viser.ViserServer, call: Callable[[], object]) -> None:
    """Schedule ``call`` in the thread of the server's connections."""
    loop = server._websock_server._background_event_loop
    assert loop is not None
    loop.call_soon_threadsafe(call)


def widget(server: viser.ViserServer, connection: object, uuid: str) -> Any:
    """Find a widget by its id in the tab behind a websocket; None without one."""
    client = tab(server, connection)
    return None if client is None else client.gui._gui_input_handle_from_uuid.get(uuid)


def tab(server: viser.ViserServer, connection: object) -> viser.ClientHandle | None:
    """Find the tab behind a websocket; None before it has reported its camera."""
    for number, live in tuple(server._websock_server._live_connections.items()):
        if live is connection:
            return server._connected_clients.get(number)
    return None


def set_lines(plot: viser.GuiUplotHandle, lines: Sequence[NDArray[np.float32]]) -> None:
    """Show ``lines`` (m,) over the first of them in a plot, in single precision.

    viser itself sends them in double precision, of which the page has no use.
    """
    vars(plot._impl.props)["data"] = tuple(lines)
    plot._queue_update("data", tuple(lines))


def move_gizmo(
    client: viser.ClientHandle,
    name: str,
    owner: str,
    wxyz: tuple[float, float, float, float],
    position: tuple[float, float, float],
) -> bool:
    """Move a gizmo to the pose that the page reports, and call its callbacks.

    A hand sends twenty such messages a second, and viser takes ten times as long over one.

    Args:
        client: the tab.
        name: of the gizmo's node.
        owner: of the node, as the page has it.
        wxyz: unit quaternion of the gizmo in its parent's frame.
        position: of the gizmo in that frame, [unit].

    Returns:
        Whether it is done: not where other tabs, or other tabs' gizmos, have to do with it.
    """
    scene = client.scene
    key: Any = (client.client_id, name)
    held = scene._active_transform_drag_handles.get(key)
    gizmo = held or scene._handle_from_transform_controls_name.get(name)
    if gizmo is None or owner != scene._owner_id or gizmo._impl_aux.sync_cb is not None:
        return False
    gizmo._impl.wxyz, gizmo._impl.position = np.array(wxyz), np.array(position)
    gizmo._impl_aux.last_updated = time.time()
    event = viser.TransformControlsEvent(client, client.client_id, gizmo, "update")
    for call in gizmo._impl_aux.update_cb:
        try:
            call(event)
        except Exception as error:
            print_awaited_callback_error(error)
    return True


def keep_to_tab(gizmo: viser.TransformControlsHandle) -> None:
    """Do not send a gizmo's pose to other tabs: none shows this tab's gizmos."""
    gizmo._impl_aux.sync_cb = None


def _run(client: viser.ClientHandle, script: str, slot: str = "") -> None:
    """Run a script in the page; it replaces an unsent one in the same ``slot``."""
    message = _messages.RunJavascriptMessage(source=script)
    # viser asks again when it has sent the message: another answer, as its own, is kept for ever
    key = f"run {slot or uuids.uuid4()}"
    message.redundancy_key = functools.partial(str, key)  # type: ignore[method-assign]
    client._websock_connection.queue_message(message)


@functools.cache
def _script() -> str:
    """The page's scripts, without indentation and comment lines."""
    files = ("page.js", "files.js", "labels.js", "nodes.js", "keyboard.js", "sight.js")
    text = "\n".join(assets.path("page", name).read_text(encoding="utf-8") for name in files)
    lines = (line.strip() for line in text.splitlines())
    return "\n".join(line for line in lines if not _COMMENT.fullmatch(line))
