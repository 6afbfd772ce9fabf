"""A recorder never stops a loop, and says in words why it stopped recording."""

from __future__ import annotations

import itertools
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from fleet.recording.disk import DiskStream, free_bytes, parts
from fleet.recording.reader import RecordingFile, read
from fleet.recording.seam import Attachment, MemoryRecorder, NullRecorder, Recording
from fleet.recording.writer import Recorder

FAST = {"flush_s": 0.1, "fsync_s": 0.2}


def wait_for(condition: object, timeout_s: float = 10.0) -> None:
    """Until `condition()` holds."""
    end = time.monotonic() + timeout_s
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.01)


def test_what_was_put_is_read_back_with_header_and_attachment(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap", {"mission": "a"}, [Attachment("m.toml", "text/plain", b"x = 1")])
    recorder.channel("/a/state", "fleet.State", "json", b'{"type":"object","properties":{}}')
    recorder.channel("/a/inputs", "fleet.Inputs", "msgpack")
    for i in range(100):
        recorder.put("/a/state", i * 10, b'{"i":%d}' % i)
        recorder.put("/a/inputs", i * 10 + 1, bytes([i]))
    recorder.close()
    assert (recorder.trouble, recorder.dropped, recorder.written) == ("", 0, 200)
    with RecordingFile(tmp_path / "run.mcap") as file:
        assert file.whole
        assert file.header["mission"] == "a"
        assert [one.content for one in file.attachments()] == [b"x = 1"]
        assert file.topics == {"/a/state": "fleet.State", "/a/inputs": "fleet.Inputs"}
        assert [json.loads(one.payload)["i"] for one in file.messages(["/a/state"])] == list(range(100))
        assert {one.encoding for one in file.messages(["/a/inputs"])} == {"msgpack"}


def test_a_topic_nobody_declared_is_kept_without_a_schema(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap")
    recorder.put("/surprise", 1, b'{"a":1}')
    recorder.put("/raw", 2, b"\x81\x01\x02")
    recorder.close()
    assert [(one.topic, one.encoding) for one in read(recorder.path)] == [("/surprise", "json"), ("/raw", "msgpack")]


def test_an_impossible_stamp_or_payload_is_dropped_and_counted_and_the_rest_is_kept(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap")
    recorder.put("/a", -1, b"{}")
    recorder.put("/a", 1, "text")  # type: ignore[arg-type]
    recorder.put("/a", 2, b"{}")
    recorder.close()
    assert (recorder.trouble, recorder.dropped) == ("", 2)
    assert [one.stamp_ns for one in read(recorder.path)] == [2]


def test_an_existing_recording_is_never_overwritten_a_restart_begins_the_next_part(tmp_path: Path) -> None:
    for i in range(3):
        recorder = Recorder(tmp_path / "otter-1.mcap")
        recorder.put("/a", i, b"{}")
        recorder.close()
    names = [one.name for one in parts(tmp_path / "otter-1.mcap")]
    assert names == ["otter-1.mcap", "otter-1.2.mcap", "otter-1.3.mcap"]
    assert [one.stamp_ns for one in read(tmp_path / "otter-1.mcap")] == [0, 1, 2]


def test_a_new_part_begins_when_one_is_long_enough_and_nothing_is_lost_between(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap", flush_s=0.05, fsync_s=0.05, part_bytes=20_000)
    for i in range(600):
        recorder.put("/a", i, os.urandom(200))
        if i % 100 == 99:
            time.sleep(0.15)
    recorder.close()
    assert len(parts(tmp_path / "run.mcap")) > 2
    assert [one.stamp_ns for one in read(tmp_path / "run.mcap")] == list(range(600))


def test_what_does_not_fit_into_the_queue_is_dropped_and_counted_never_waited_for(tmp_path: Path) -> None:
    gate = threading.Event()

    class Stuck(DiskStream):
        def write(self, content: bytes | bytearray | memoryview, /) -> int:  # type: ignore[override]
            if len(content) > 1000:
                gate.wait(10.0)
            return super().write(content)

    recorder = Recorder(tmp_path / "run.mcap", room=50, open_stream=Stuck, **FAST)
    recorder.put("/a", 0, os.urandom(5000))
    wait_for(lambda: recorder.written == 1)
    time.sleep(0.3)  # by now the disk is stuck in its flush
    began = time.perf_counter()
    for i in range(1000):
        recorder.put("/a", i, b"{}")
    assert time.perf_counter() - began < 0.1
    assert recorder.dropped == 950
    began = time.perf_counter()
    recorder.close(timeout_s=0.2)
    assert time.perf_counter() - began < 1.0
    assert recorder.trouble.startswith("disk too slow: 50 messages not written")
    gate.set()


def test_a_simulator_without_a_clock_waits_for_room_and_loses_nothing(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap", room=100, wait=True)
    for i in range(5000):
        recorder.put("/a", i, b'{"a":1}')
    recorder.close()
    assert (recorder.dropped, recorder.written) == (0, 5000)


def test_a_full_device_is_said_in_words_and_nothing_raises(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.mcap", open_stream=lambda _: DiskStream(Path("/dev/full"), flags=0))
    assert recorder.trouble.startswith("disk full: ")
    recorder.put("/a", 1, b"{}")
    recorder.close()
    assert recorder.dropped == 1


def test_a_folder_that_cannot_be_made_is_said_in_words(tmp_path: Path) -> None:
    (tmp_path / "boats").write_text("a file, not a folder")
    recorder = Recorder(tmp_path / "boats" / "a.mcap")
    assert recorder.trouble.startswith("cannot write: ")
    recorder.close()


@pytest.fixture
def small_disk(tmp_path: Path) -> Path:
    """A real file system of 256 kB."""
    place = tmp_path / "small"
    place.mkdir()
    made = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", place], capture_output=True, check=False)
    if made.returncode:
        pytest.skip("needs the right to mount; the size limit and /dev/full are tested anyway")
    yield place  # type: ignore[misc]
    subprocess.run(["umount", "-l", place], check=True)


def test_on_a_disk_that_fills_up_the_recording_stops_and_what_was_flushed_is_read_back(small_disk: Path) -> None:
    recorder = Recorder(small_disk / "run.mcap", reserve_bytes=0, **FAST)
    for i in range(1000):
        recorder.put("/a", i, os.urandom(1000))
    wait_for(lambda: recorder.trouble)
    assert recorder.trouble.startswith("disk full: ")
    recorder.put("/a", 1, b"{}")
    recorder.close()
    stamps = [one.stamp_ns for one in read(small_disk / "run.mcap")]
    assert len(stamps) > 50
    assert stamps == list(range(len(stamps)))


def test_before_the_disk_is_full_the_recording_ends_in_good_order(small_disk: Path) -> None:
    recorder = Recorder(small_disk / "run.mcap", reserve_bytes=150_000, **FAST)
    for i in range(150):
        recorder.put("/a", i, os.urandom(1000))
    wait_for(lambda: recorder.trouble)
    assert recorder.trouble.startswith("disk nearly full: ")
    with RecordingFile(small_disk / "run.mcap") as file:
        assert file.whole
        assert file.message_count == 150
    recorder.close()


LIMITED = """
import os, resource, sys, time
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
from fleet.recording.writer import Recorder
recorder = Recorder(sys.argv[1], flush_s=0.1)
for i in range(300):
    recorder.put("/a", i, os.urandom(1000))
end = time.monotonic() + 10
while not recorder.trouble and time.monotonic() < end:
    time.sleep(0.01)
recorder.close()
print(recorder.trouble)
"""


def test_a_limit_on_the_size_of_files_is_said_in_words(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, tmp_path / "run.mcap"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("largest file size reached: ")
    assert done.stderr == ""
    stamps = [one.stamp_ns for one in read(tmp_path / "run.mcap")]
    assert stamps == list(range(len(stamps)))


WRITING = """
import os, sys, time
from fleet.recording.writer import Recorder
recorder = Recorder(sys.argv[1], flush_s=0.5)
recorder.channel("/a", "A", "json", b'{"type":"object","properties":{}}')
print("begun", flush=True)
while True:
    recorder.put("/a", time.time_ns(), b'{"x":"%s"}' % os.urandom(40).hex().encode())
    time.sleep(0.002)
"""


def test_kill_9_costs_what_was_put_since_the_last_flush_and_no_more(tmp_path: Path) -> None:
    process = subprocess.Popen([sys.executable, "-c", WRITING, tmp_path / "run.mcap"], stdout=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(2.3)
    killed_ns = time.time_ns()
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    stamps = [one.stamp_ns for one in read(tmp_path / "run.mcap")]
    assert 0.0 <= (killed_ns - stamps[-1]) / 1e9 < 0.5 + 0.1 + 0.5  # flush, poll, a busy machine
    assert max(b - a for a, b in itertools.pairwise(stamps)) < 0.5e9  # and no hole before


def test_free_space_is_asked_of_the_place_where_the_file_will_be(tmp_path: Path) -> None:
    assert free_bytes(tmp_path / "not" / "yet" / "run.mcap") == pytest.approx(free_bytes(tmp_path), rel=0.05)


@pytest.mark.parametrize("recorder", [NullRecorder(), MemoryRecorder()])
def test_the_recorders_without_a_disk_answer_to_the_same_calls(recorder: Recording) -> None:
    recorder.channel("/a", "A", "json")
    recorder.put("/a", 1, b"{}")
    recorder.put("/b", 1, b"\x80")
    recorder.close()
    assert (recorder.trouble, recorder.dropped) == ("", 0)
