"""Files on their way: on disk from a size on, within one budget, and gone with whoever sends."""

from __future__ import annotations

import errno
import gc
import io
import tempfile
from typing import IO, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.guard.messages import UploadPart, UploadStart
from app.guard.uploads import MAX_TRANSFERS, Uploads
from app.process.memory_budget import MemoryBudget, memory_for_uploads
from app.reading import stored_upload
from app.reading.stored_upload import IN_MEMORY, StoredUpload
from app.server.server import Server
from app.tab.session import Session
from app.ui import page
from tests.app.fake_tab import opened, until

PART = 500_000
HALF = 4


def _announced(session: Session, name: str) -> dict[str, Any]:
    return {
        "type": "FileTransferStartUpload",
        "source_component_uuid": page.uuid(session.panels.files.upload),
        "transfer_uuid": name,
        "filename": f"{name}.zip",
        "mime_type": "",
        "part_count": 2 * HALF,
        "size_bytes": 2 * HALF * PART,
    }


def free(budget: MemoryBudget) -> int:
    """Bytes that one more file may take."""
    return budget.left(-1)


@given(st.permutations(range(5)), st.lists(st.binary(max_size=40), min_size=5, max_size=5))
def test_parts_come_back_in_their_order_however_they_come(
    order: list[int], parts: list[bytes]
) -> None:
    budget = MemoryBudget(1000)
    file = StoredUpload(budget)
    for number in order:
        file[number] = parts[number]
    assert [file[number] for number in range(5)] == parts
    assert file.content() == b"".join(parts)
    assert free(budget) == 1000 - len(file.content())
    file.close()
    file.close()
    assert free(budget) == 1000


def test_a_file_of_some_size_is_on_disk() -> None:
    file = StoredUpload(MemoryBudget(10 * IN_MEMORY))
    held: Any = file._file
    file[0] = bytes(IN_MEMORY)
    assert not held._rolled
    file[1] = b"x"
    assert held._rolled
    assert file[1] == b"x"


def test_what_finds_no_memory_keeps_none_and_says_so() -> None:
    budget = MemoryBudget(100)
    first, second = StoredUpload(budget), StoredUpload(budget)
    first[0] = bytes(60)
    second[0] = b"a" * 30
    second[1] = b"b" * 30
    second[2] = b"c" * 5
    assert free(budget) == 40
    assert "fewer files" in second.lost
    assert first.lost == ""
    # of the length that was sent: who puts it together compares that
    assert second.content() == bytes(65)
    del first, second
    assert free(budget) == 100


def test_a_full_disk_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    class Full(io.BytesIO):
        def write(self, content: Any) -> int:
            raise OSError(errno.ENOSPC, "no space left on device")

    monkeypatch.setattr(stored_upload, "_new_file", Full)
    budget = MemoryBudget(100)
    file = StoredUpload(budget)
    file[0] = b"abc"
    assert "place to keep it" in file.lost
    assert free(budget) == 100


def test_without_a_place_to_write_files_are_in_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere() -> str:
        raise FileNotFoundError

    monkeypatch.setattr(tempfile, "gettempdir", nowhere)
    file: IO[bytes] = stored_upload._new_file()
    assert isinstance(file, io.BytesIO)


def test_uploads_have_a_part_of_the_memory() -> None:
    assert memory_for_uploads(None) >= memory_for_uploads(2 * 10**9) == 250_000_000
    assert memory_for_uploads(10**12) == memory_for_uploads(None)


def test_half_a_file_is_gone_with_its_tab(server: Server) -> None:
    budget = stored_upload.BUDGET
    until(lambda: not server.sessions)
    before = free(budget)
    fake, session = opened(server)
    for name in "ab":
        fake.send(_announced(session, name))
        for number in range(HALF):
            part = {"type": "FileTransferPart", "transfer_uuid": name, "part_index": number}
            button = page.uuid(session.panels.files.upload)
            fake.send({**part, "source_component_uuid": button, "content": bytes(PART)})
    until(lambda: free(budget) == before - 2 * HALF * PART)
    del session
    gc.disable()  # at once, not when garbage is looked for
    try:
        fake.close()
        until(lambda: free(budget) == before)
    finally:
        gc.enable()


def test_a_file_is_forgotten_that_does_not_come_in_time(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "LIFETIME", 0.2)
    budget, before = stored_upload.BUDGET, free(stored_upload.BUDGET)
    fake, session = opened(server)
    fake.send(_announced(session, "a"))
    button = page.uuid(session.panels.files.upload)
    part = {"type": "FileTransferPart", "transfer_uuid": "a", "part_index": 0}
    fake.send({**part, "source_component_uuid": button, "content": bytes(PART)})
    until(lambda: free(budget) == before - PART)
    until(lambda: free(budget) == before)
    until(lambda: "nothing more of it comes" in session.panels.files.uploads._line.content)
    assert session.client.gui._current_file_upload_states == {}
    fake.close()
    until(lambda: not server.sessions)


def test_a_file_that_did_not_come_in_time_makes_room_for_another(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Button:
        mime_type = ".stl"

    starts = [UploadStart("button", name, "a.stl", "", 2, 10) for name in "abcd"]
    uploads = Uploads()
    assert [uploads.begins(start, Button()) for start in starts[:3]] == [True] * MAX_TRANSFERS + [
        False
    ]
    monkeypatch.setattr(page, "LIFETIME", 0.0)
    assert uploads.begins(starts[3], Button())
    assert not uploads.continues(UploadPart("button", "a", 0, b"x"))
    assert uploads.continues(UploadPart("button", "d", 0, b"x"))
