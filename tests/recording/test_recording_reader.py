"""Whatever a crash leaves of a recording is read up to its last whole record, and repaired."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer

from fleet.errors import RecordingError
from fleet.recording.layout import layout_of
from fleet.recording.reader import RecordingFile, read, repair

CHUNKS, EACH, PAYLOAD = 9, 4, 600


def recorded(chunk_messages: int = EACH) -> tuple[bytes, list[int]]:
    """A closed recording of 9 chunks, and where each chunk ends."""
    stream = io.BytesIO()
    writer: Any = Writer(stream)
    writer.start(library="fleet")
    writer.add_metadata("run", {"mission": "cut"})
    writer.add_attachment(0, 0, "mission.toml", "text/plain", b"title = 1")
    schema = writer.register_schema("fleet.A", "jsonschema", b'{"type":"object","properties":{}}')
    channels = [writer.register_channel(f"/{name}", "json", schema) for name in "ab"]
    ends = []
    for i in range(CHUNKS):
        for k in range(chunk_messages):
            number = i * chunk_messages + k
            writer.add_message(channels[number % 2], 1000 + number, os.urandom(PAYLOAD), 1000 + number)
        before = stream.tell()
        writer.flush()
        length = int.from_bytes(stream.getvalue()[before + 1 : before + 9], "little")
        ends.append(before + 9 + length)
    writer.finish()
    return stream.getvalue(), ends


def test_cut_at_every_byte_of_its_last_20_kilobytes_everything_flushed_before_is_found() -> None:
    content, ends = recorded()
    assert len(content) > 20_000
    for cut in range(len(content) - 20_000, len(content)):
        found = layout_of(io.BytesIO(content[:cut]), "cut")
        whole = sum(end <= cut for end in ends)
        assert (found.messages, found.bad_chunks, found.whole) == (EACH * whole, 0, False), cut
        assert found.metadata["run"] == {"mission": "cut"}


def test_a_repaired_file_opens_with_an_index_and_holds_everything_wherever_it_was_cut(tmp_path: Path) -> None:
    content, ends = recorded()
    interesting = {end + k for end in ends for k in (-1, 0, 1)} | set(range(300, len(content), 991))
    for cut in sorted(one for one in interesting if one < len(content)):
        (tmp_path / "cut.mcap").write_bytes(content[:cut])
        done = repair(tmp_path / "cut.mcap", tmp_path / "out.mcap")
        whole = sum(end <= cut for end in ends)
        assert (done.messages, done.was_whole, done.bad_chunks) == (EACH * whole, False, 0)
        assert 0 <= done.lost_tail_bytes < EACH * PAYLOAD * 2
        with RecordingFile(tmp_path / "out.mcap") as file:
            assert file.whole
            assert file.header == {"mission": "cut"}
            assert [one.stamp_ns for one in file.messages()] == [1000 + i for i in range(EACH * whole)]
            if cut > 400:
                assert [one.content for one in file.attachments()] == [b"title = 1"]
        (tmp_path / "out.mcap").unlink()


def test_a_whole_file_is_read_through_its_index(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(recorded()[0])
    with RecordingFile(tmp_path / "a.mcap") as file:
        assert (file.whole, file.lost_tail_bytes, file.message_count) == (True, 0, 36)
        assert file.span_ns == (1000, 1035)
        assert [one.stamp_ns for one in file.messages(["/a"], since_ns=1010, until_ns=1016)] == [1010, 1012, 1014]
        assert list(file.messages(["/nobody"])) == []


def test_a_damaged_file_answers_the_same_questions(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(recorded()[0][:-1])
    with RecordingFile(tmp_path / "a.mcap") as file:
        assert not file.whole
        assert file.span_ns == (1000, 1035)
        assert [one.stamp_ns for one in file.messages(["/a"], since_ns=1010, until_ns=1016)] == [1010, 1012, 1014]


def test_a_chunk_with_a_wrong_checksum_is_passed_over_and_counted(tmp_path: Path) -> None:
    content, ends = recorded()
    broken = bytearray(content)
    broken[ends[3] - 700] ^= 0xFF
    (tmp_path / "a.mcap").write_bytes(broken)
    with RecordingFile(tmp_path / "a.mcap") as file:
        stamps = [one.stamp_ns for one in file.messages()]
        assert file.bad_chunks == 1
    assert stamps == [1000 + i for i in range(36) if not 12 <= i < 16]
    done = repair(tmp_path / "a.mcap", tmp_path / "b.mcap")
    assert (done.messages, done.bad_chunks, done.was_whole) == (32, 1, False)


def test_zeros_that_a_power_cut_leaves_at_the_end_are_not_taken_for_records(tmp_path: Path) -> None:
    content, ends = recorded()
    (tmp_path / "a.mcap").write_bytes(content[: ends[4]] + bytes(4096))
    with RecordingFile(tmp_path / "a.mcap") as file:
        assert file.message_count == 20
        assert file.lost_tail_bytes == 4096


def test_random_damage_anywhere_is_never_a_traceback(tmp_path: Path) -> None:
    content, _ = recorded()
    for at in range(8, len(content), 61):
        broken = bytearray(content)
        broken[at] ^= 0xA5
        (tmp_path / "a.mcap").write_bytes(broken)
        assert len(list(read(tmp_path / "a.mcap"))) <= 36


def test_messages_of_several_chunks_come_in_the_order_of_their_stamps(tmp_path: Path) -> None:
    with (tmp_path / "a.mcap").open("wb") as stream:
        writer: Any = Writer(stream)
        writer.start()
        channel = writer.register_channel("/a", "json", 0)
        for chunk in ([5, 1, 9], [4, 2], [20, 8], [30]):
            for stamp in chunk:
                writer.add_message(channel, stamp, b"{}", stamp)
            writer.flush()
        writer.finish()
    assert [one.stamp_ns for one in read(tmp_path / "a.mcap")] == [1, 2, 4, 5, 8, 9, 20, 30]


def test_a_recording_without_chunks_from_another_tool_is_read_too(tmp_path: Path) -> None:
    with (tmp_path / "a.mcap").open("wb") as stream:
        writer: Any = Writer(stream, use_chunking=False)
        writer.start()
        channel = writer.register_channel("/a", "json", 0)
        for stamp in range(10):
            writer.add_message(channel, stamp, b"{}", stamp)
        writer.finish()
    assert [one.stamp_ns for one in read(tmp_path / "a.mcap")] == list(range(10))


@pytest.mark.parametrize("content", [b"", b"\x89MCAP", b"time,x,y\n1,2,3\n", bytes(1000)])
def test_what_is_no_recording_is_refused_in_words(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(RecordingError, match=r"a\.mcap: not a recording: it (is empty|begins with)"):
        list(read(tmp_path / "a.mcap"))


def test_a_missing_file_and_an_existing_target_are_refused_in_words(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"cannot read .*No such file"):
        list(read(tmp_path / "a.mcap"))
    (tmp_path / "a.mcap").write_bytes(recorded()[0])
    with pytest.raises(RecordingError, match="exists already"):
        repair(tmp_path / "a.mcap", tmp_path / "a.mcap")
