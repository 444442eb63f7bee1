"""A pose reaches the page wherever the page may have another, though viser takes it for known."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import viser

from app.tab.session import Session
from app.ui import node_poses
from tests.app.fake_tab import FakeTab

_POSES = ("SetPositionMessage", "SetOrientationMessage")


@pytest.fixture
def client(tab: tuple[FakeTab, Session]) -> Iterator[viser.ClientHandle]:
    """A tab to which nothing is sent as long as the test lasts."""
    _, session = tab
    with session.client.atomic():
        yield session.client


def _sent(client: viser.ClientHandle, name: str) -> list[str]:
    """Kinds of the messages about a node's pose that wait to be sent."""
    messages: list[Any] = list(
        client._websock_connection.get_message_buffer().message_from_id.values()
    )
    kinds = [type(one).__name__ for one in messages if getattr(one, "name", "") == name]
    return [kind for kind in kinds if kind in _POSES]


@pytest.mark.slow
def test_a_node_that_is_added_again_says_where_it_is(client: viser.ClientHandle) -> None:
    node = client.scene.add_frame("/again", position=(1.0, 2.0, 3.0))
    node.remove()
    assert _sent(client, "/again") == []
    client.scene.add_frame("/again")
    assert sorted(_sent(client, "/again")) == sorted(_POSES)


@pytest.mark.slow
def test_a_forgotten_pose_is_sent_though_it_is_the_same(client: viser.ClientHandle) -> None:
    place, turn = np.array((1.0, 2.0, 3.0)), np.array((0.0, 1.0, 0.0, 0.0))
    node = client.scene.add_frame("/forgotten", position=place, wxyz=turn)
    before = client._websock_connection.get_message_buffer().message_counter
    node.position, node.wxyz = place, turn
    assert client._websock_connection.get_message_buffer().message_counter == before
    node_poses.forget(node)
    node.position, node.wxyz = place, turn
    assert client._websock_connection.get_message_buffer().message_counter == before + 2
    np.testing.assert_array_equal(node.position, place)
    np.testing.assert_array_equal(node.wxyz, turn)
