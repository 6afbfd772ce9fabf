"""UDP, TCP and serial links, and frames cut out of what they bring."""

from __future__ import annotations

import os
import socket
import sys
import tty
from typing import Any

import pytest

from fleet.drivers.mavlink.config import MavlinkConfig
from fleet.drivers.mavlink.frames import Frames
from fleet.drivers.mavlink.link import SerialLink, TcpLink, UdpLink, link_to
from fleet.drivers.mavlink.talk import Talk
from fleet.drivers.mavlink.words import dialect
from fleet.errors import ConfigError

MAVLINK = dialect()
BOAT = MAVLINK.MAVLink(None, srcSystem=1, srcComponent=1)


def beat(mode: int = 15, sysid: int = 1) -> bytes:
    codec = MAVLINK.MAVLink(None, srcSystem=sysid, srcComponent=1)
    return bytes(MAVLINK.MAVLink_heartbeat_message(11, 3, 129, mode, 4, 3).pack(codec))


def modes(messages: Any) -> list[int]:
    return [message.custom_mode for message in messages]


# -- frames ------------------------------------------------------------------------------------------------------------
def test_a_datagram_may_hold_several_frames() -> None:
    frames = Frames(MAVLINK, 1, 1)
    assert modes(frames.datagram(beat(4) + beat(15))) == [4, 15]
    assert frames.counts == {"taken": 2}


def test_a_stream_may_be_cut_anywhere() -> None:
    whole = beat(3) + beat(4) + beat(15)
    for k in range(1, len(whole)):
        frames = Frames(MAVLINK, 1, 1)
        assert modes([*frames.stream(whole[:k]), *frames.stream(whole[k:])]) == [3, 4, 15]


def test_junk_that_looks_like_a_header_swallows_no_frame() -> None:
    frames = Frames(MAVLINK, 1, 1)
    junk = b"\xfd\xc8\x00 boot banner"  # says that it is 212 bytes long
    found = modes(frames.stream(junk + b"".join(beat(m) for m in range(12))))
    assert found == list(range(12))


def test_a_wrong_bit_is_a_bad_frame_and_the_next_one_is_good() -> None:
    frames = Frames(MAVLINK, 1, 1)
    broken = bytearray(beat(4))
    broken[12] ^= 0x10
    assert modes(frames.datagram(bytes(broken) + beat(15))) == [15]
    assert frames.counts["bad"] >= 1


def test_others_on_the_link_are_counted_and_not_read() -> None:
    frames = Frames(MAVLINK, 1, 1)
    assert modes(frames.datagram(beat(4, sysid=9) + beat(15))) == [15]
    assert frames.counts == {"others": 1, "taken": 1}


def test_signed_frames_are_read_without_a_key() -> None:
    codec = MAVLINK.MAVLink(None, srcSystem=1, srcComponent=1)
    codec.signing.secret_key, codec.signing.sign_outgoing = b"k" * 32, True
    signed = bytes(MAVLINK.MAVLink_heartbeat_message(11, 3, 129, 15, 4, 3).pack(codec))
    assert modes(Frames(MAVLINK, 1, 1).datagram(signed + beat(4))) == [15, 4]


def test_a_set_point_on_the_wire_says_what_rover_honours() -> None:
    talk = Talk(MAVLINK, 254, 1)
    (said,) = Frames(MAVLINK).datagram(talk.setpoint(12_000, 1.25, -0.1))
    assert (said.get_srcSystem(), said.get_srcComponent(), said.target_system) == (254, 191, 1)
    assert (said.coordinate_frame, said.type_mask) == (8, 0x5C7)
    assert (said.vx, said.vy, said.yaw_rate) == (1.25, 0.0, pytest.approx(-0.1))


# -- links -------------------------------------------------------------------------------------------------------------
def test_udp_in_answers_whoever_spoke() -> None:
    ours = UdpLink(("127.0.0.1", 0), listens=True)
    ours.open()
    assert ours.send(beat()) == "no autopilot has spoken yet"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as theirs:
        theirs.bind(("127.0.0.1", 0))
        theirs.settimeout(5.0)
        theirs.sendto(beat(4), ("127.0.0.1", ours.port))
        assert ours.receive() == [beat(4)]
        assert ours.send(beat(15)) == ""
        assert theirs.recv(500) == beat(15)
    ours.close()


def test_a_closed_udp_port_is_said_and_never_raised() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as gone:
        gone.bind(("127.0.0.1", 0))
        port = gone.getsockname()[1]
    link = UdpLink(("127.0.0.1", port), listens=False)
    link.open()
    assert "the autopilot's port is closed" in {link.send(beat()) for _ in range(10)}
    assert link.receive() == []
    link.close()
    assert link.send(beat()) == "not connected to the autopilot"


def test_a_udp_socket_that_was_shut_is_said_and_another_one_is_opened() -> None:
    far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    far.bind(("127.0.0.1", 0))
    link = UdpLink(far.getsockname(), listens=False)
    link.open()
    assert link._socket is not None
    link._socket.shutdown(socket.SHUT_RDWR)
    assert link.send(b"x") == "the autopilot cannot be reached: Broken pipe"
    assert not link.up
    assert link.send(b"x") == "not connected to the autopilot"
    link.open()  # as the driver does every 2 s
    assert link.send(b"y") == ""
    assert far.recv(10) == b"y"
    link.close()
    far.close()


def test_tcp_sends_whole_frames_or_none_and_nothing_waits_in_a_queue() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = TcpLink(server.getsockname())
        link.open()
        theirs, _ = server.accept()
        theirs.sendall(beat(4))
        assert link.receive() == [beat(4)]
        said = {link.send(b"x" * 200) for _ in range(200_000)}  # nobody reads
        assert said == {"", "the link to the autopilot is jammed"}
        assert link._unsent() <= 256 + 200, "what waits is at most a frame more"
        theirs.close()
        for _ in range(3):
            link.receive()
        assert not link.up
        assert link.send(beat()).startswith("the link to the autopilot is lost: ")


def test_a_serial_line_carries_bytes_unchanged() -> None:
    ours, line = os.openpty()
    tty.setraw(ours)
    link = SerialLink(os.ttyname(line), 57600)
    link.open()
    payload = bytes(range(256))
    os.write(ours, payload)
    assert b"".join(link.receive()) == payload
    assert link.send(payload[:200]) == ""
    assert os.read(ours, 500) == payload[:200]
    os.close(line)
    os.close(ours)
    link.receive()
    assert not link.up
    assert link.send(beat()).startswith("the link to the autopilot is lost: ")


@pytest.mark.parametrize(
    "endpoint",
    ["x", "udp:", "udp:127.0.0.1", "udp:127.0.0.1:0", "tcp:host:70000", "serial:/dev/ttyS0", "serial:/dev/ttyS0:12345"],
)
def test_an_endpoint_that_means_nothing_is_refused_with_what_was_expected(endpoint: str) -> None:
    with pytest.raises(ConfigError, match="expected udp:HOST:PORT, udpin:HOST:PORT"):
        link_to(endpoint)


def test_what_cannot_be_opened_is_said(tmp_path: Any) -> None:
    with pytest.raises(ConfigError, match="No such file"):
        link_to(f"serial:{tmp_path}/none:57600").open()
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="not a serial line"):
        link_to(f"serial:{tmp_path}/file:57600").open()
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as gone:
        gone.bind(("127.0.0.1", 0))
        with pytest.raises(ConfigError, match="refused"):
            link_to(f"tcp:127.0.0.1:{gone.getsockname()[1]}").open()


def test_a_configuration_without_an_endpoint_or_with_two_equal_sysids_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"driver\.mavlink\.endpoint: missing"):
        MavlinkConfig().check()
    with pytest.raises(ConfigError, match="own_sysid = 9: the autopilot's sysid"):
        MavlinkConfig(endpoint="udp:127.0.0.1:14550", sysid=9, own_sysid=9).check()


def test_without_pymavlink_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pymavlink.dialects.v20", None)
    with pytest.raises(ConfigError, match=r"pip install 'fleet-usv\[mavlink\]'"):
        dialect()
