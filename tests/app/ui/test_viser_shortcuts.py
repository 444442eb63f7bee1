"""Shortcuts in viser send what viser would, and nothing where nothing has changed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from viser import _messages as scene_messages
from viser.infra import _messages as messages

from app.tab.session import Session
from app.ui import viser_shortcuts
from tests.app.fake_tab import FakeTab

_UPDATE = {"points": np.arange(12.0).reshape(2, 2, 3), "thickness": 2}
_MESSAGES: list[Any] = [
    scene_messages.SceneNodeUpdateMessage("/line", _UPDATE),
    scene_messages.GuiUpdateMessage("/line", _UPDATE),
    scene_messages.SetPositionMessage("/a", (1, 2.5, np.float32(3))),  # type: ignore[arg-type]
    scene_messages.SetSceneNodeVisibilityMessage("/a", visible=bool(np.True_)),
    scene_messages.SceneNodeUpdateMessage("/a", {"nested": {"text": "x", "none": None}}),
    scene_messages.SceneNodeUpdateMessage("/a", {"list": [1, True, np.int64(3), "x", 0.5]}),
    scene_messages.RunJavascriptMessage("1 + 1"),
]


@pytest.mark.parametrize("message", _MESSAGES)
def test_the_same_is_sent(message: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def sent() -> tuple[Any, list[bytes]]:
        buffers: list[memoryview] = []
        return message.as_serializable_dict(buffers), [bytes(one) for one in buffers]

    monkeypatch.setattr(messages, "_prepare_for_serialization", viser_shortcuts._prepare)
    expected = sent()
    monkeypatch.setattr(messages, "_prepare_for_serialization", viser_shortcuts._prepare_field)
    assert repr(sent()) == repr(expected)  # also of the same types: 1 is not True


@pytest.mark.slow
def test_only_what_changes_is_sent(tab: tuple[FakeTab, Session]) -> None:
    _, session = tab
    buffer = session.client._websock_connection.get_message_buffer()
    with session.client.atomic():
        text = session.client.gui.add_html("one")
        label = session.client.scene.add_label("/test", "one", position=(1.0, 2.0, 3.0))
        for handle, change, times in (
            (text, {"content": "one"}, 0),
            (text, {"content": "two"}, 1),
            (text, {"visible": True}, 0),
            (text, {"visible": False}, 1),
            (label, {"text": "one"}, 0),
            (label, {"text": "two"}, 1),
            (label, {"font_screen_scale": 2}, 1),
            (label, {"position": (1.0, 2.0, 3.0)}, 0),
            (label, {"position": np.array([1.0, 2.0, 4.0])}, 1),
            (label, {"visible": True}, 0),
            (label, {"visible": False}, 1),
        ):
            before = buffer.message_counter
            for name, value in change.items():
                setattr(handle, name, value)
                assert np.array_equal(getattr(handle, name), value)
            assert buffer.message_counter - before == times
        text.remove()
        with pytest.raises(RuntimeError):
            text.content = "two"


@pytest.mark.slow
def test_an_array_is_sent_as_it_was_when_it_was_set(tab: tuple[FakeTab, Session]) -> None:
    _, session = tab
    buffer = session.client._websock_connection.get_message_buffer()
    ones = np.ones((1, 2, 3), np.float32)

    def sent() -> list[Any]:
        """Fields that were set and have not gone yet."""
        waiting: list[Any] = list(buffer.message_from_id.values())
        own = [one for one in waiting if getattr(one, "name", "") == "/array"]
        return [one.updates for one in own if "points" in getattr(one, "updates", {})]

    with session.client.atomic():
        line = session.client.scene.add_line_segments("/array", ones, (255, 0, 0))
        same: Any = 2.0 * np.ones((1, 2, 3))
        for points, times in ((ones, 0), (2 * ones, 1), (same, 0), (ones, 1)):
            before = buffer.message_counter
            line.points = points
            assert buffer.message_counter - before == times
            np.testing.assert_array_equal(line.points, points)
            assert line.points.dtype == np.float32
        changed = 3 * ones
        line.points = changed
        changed[:] = 4.0  # whose array it is may go on using it
        np.testing.assert_array_equal(line.points, 3 * ones)
        (update,) = sent()
        line.colors = np.array((1.0, 0.5, 0.0))  # as viser takes shares
        np.testing.assert_array_equal(line.colors, (255, 127, 0))
        line.points = np.concatenate([ones, ones])
        np.testing.assert_array_equal(update["points"], 3 * ones)
        assert line.points.shape == (2, 2, 3)
        line.remove()


@pytest.mark.slow
def test_a_button_that_is_not_pressed_calls_nobody(tab: tuple[FakeTab, Session]) -> None:
    _, session = tab
    called: list[object] = []
    button: Any = session.client.gui.add_button("test")
    button.on_click(called.append)
    button.value = False
    assert not called
    button.value = True
    assert len(called) == 1
    button.value = False
    assert button.value is False


def test_a_shortcut_is_taken_by_every_handle() -> None:
    impl = SimpleNamespace(removed=False, props=SimpleNamespace(label="one"))
    asked: list[str] = []

    class Handle:
        __setattr__ = viser_shortcuts._set_field

        def __init__(self) -> None:
            self.__dict__["_impl"] = impl

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(viser_shortcuts, "_set", lambda _, name, __: asked.append(name))
        handle: Any = Handle()
        handle.label = "one"
        assert asked == []
        handle.label = "two"
        handle.other = "one"
        impl.removed = True
        handle.label = "one"
    assert asked == ["label", "other", "label"]
