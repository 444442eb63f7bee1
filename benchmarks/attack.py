"""Malformed messages from hostile tabs, while another tab works on.

python -m benchmarks.attack --messages 1000000
"""

from __future__ import annotations

import argparse
import contextlib
import json
import random
import threading
import time
from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np
from websockets.exceptions import WebSocketException

from app.guard.connection import MAX_REFUSED
from app.server.server import start
from app.state.appearance import PLAIN
from app.tab.session import Session
from benchmarks.web_tab import CAMERA
from tests.app.fake_tab import FakeTab, until

_CALM = 50
"""Inputs before the attack, to compare with."""
_TYPES = ("GuiUpdateMessage", "GuiFormDirtyMessage", "ShareUrlRequest", "FileTransferPart", "", 7)


def attack(messages: int, seed: int = 0) -> dict[str, Any]:
    """Send ``messages`` malformed messages, and work in another tab until they are sent.

    Returns:
        ``messages``; ``connections`` that it took; ``seconds``; of the other tab: ``updates``, and
        the ``median_ms``, ``p99_ms`` and ``worst_ms`` from an input to its plan, beside the
        ``calm_ms`` that is the median before the attack; ``faults`` that it met.
    """
    server = start(port=0, scene="paper", look=PLAIN)
    worker = FakeTab(server.url)
    until(lambda: bool(server.sessions))
    (session,) = server.sessions.values()
    until(lambda: session.resting)
    calm = [_change(worker, session, 5.0 + 0.001 * step) for step in range(_CALM)]
    sent = [0, 0]
    begin = time.monotonic()
    hostile = threading.Thread(target=_attack, args=(server.url, messages, seed, sent))
    hostile.start()
    delays = list(_work(worker, session, hostile))
    hostile.join()
    seconds = time.monotonic() - begin
    fault = session._fault
    worker.close()
    server.stop()
    return {
        "messages": sent[0],
        "connections": sent[1],
        "seconds": seconds,
        "updates": len(delays),
        "calm_ms": 1e3 * float(np.median(calm)),
        "median_ms": 1e3 * float(np.median(delays)),
        "p99_ms": 1e3 * float(np.quantile(delays, 0.99)),
        "worst_ms": 1e3 * max(delays),
        "faults": int(fault is not None),
    }


def _work(tab: FakeTab, session: Session, hostile: threading.Thread) -> Iterator[float]:
    """Time that each change of the speed takes, [s]: as long as the attack lasts, at least once."""
    step = 0
    while step == 0 or hostile.is_alive():
        step += 1
        yield _change(tab, session, 3.0 + 0.001 * (step % 1000))


def _change(tab: FakeTab, session: Session, speed: float) -> float:
    """Time from setting the motion's speed to its plan, [s]."""
    begin = time.monotonic()
    tab.set(session.panels.stages.fields["motion.speed"], speed)
    until(lambda: session.frame.plan.scene.motion.speed == speed)
    return time.monotonic() - begin


def _attack(url: str, messages: int, seed: int, sent: list[int]) -> None:
    chance = random.Random(seed)
    while sent[0] < messages:
        sent[1] += 1
        with contextlib.suppress(WebSocketException, OSError):
            tab = FakeTab(url, greet=False)
            for _ in range(min(MAX_REFUSED + 1, messages - sent[0])):
                sent[0] += 1
                tab.send_raw(malformed(chance))
            tab.close()


def malformed(chance: random.Random) -> bytes | str:
    """A message that no page sends: noise, a damaged one, or one with wrong fields."""
    kind = chance.randrange(5)
    if kind == 0:
        return chance.randbytes(chance.randrange(200))
    if kind == 1:
        return "text" * chance.randrange(50)
    whole = msgspec.msgpack.encode(CAMERA)
    if kind == 2:
        return whole[: chance.randrange(len(whole))]
    if kind == 3:
        field = chance.choice(sorted(CAMERA))
        return msgspec.msgpack.encode({**CAMERA, field: {"a": [None] * chance.randrange(50)}})
    fields = {chance.choice("abcdef"): chance.random() for _ in range(chance.randrange(9))}
    return msgspec.msgpack.encode({"type": chance.choice(_TYPES), **fields})


def main() -> None:
    """Attack and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print(json.dumps(attack(options.messages, options.seed)), flush=True)


if __name__ == "__main__":
    main()
