"""Frames by the DBC: golden bytes, and nothing believed that is not whole."""

from __future__ import annotations

import math
import random
from pathlib import Path

import pytest

from fleet.drivers.can.decoder import Decoder
from fleet.drivers.can.frames import (
    COMMANDED,
    FIX_2D,
    FIX_3D,
    Battery,
    Frames,
    Navigation,
    Status,
    Watchdog,
)
from fleet.errors import ConfigError
from fleet.guidance.thrust import Thrusts
from tests.attack.can_frames import attack

FRAMES = Frames()
SHIPPED = Path(str(__import__("fleet.drivers.can", fromlist=["x"]).__path__[0])) / "viam.dbc"
HERE = Navigation(7, FIX_3D, True, 44.38, 8.93, 1.5, -0.25, 0.7, -0.3, 0.02)


def test_golden_bytes_of_every_frame() -> None:
    assert FRAMES.watchdog(5, True) == (256, bytes.fromhex("0501a01d"))
    identifier, payload = FRAMES.thrust(Thrusts(133.0, -66.0, 12.3, -12.3))
    assert identifier == 257
    assert payload[:6].hex() == "32c5d67b50f8"  # 1330, -660, 123, -123 in 12 bits each
    place, moves, check = FRAMES.navigation(HERE)
    assert place == (528, (443800000).to_bytes(4, "little") + (89300000).to_bytes(4, "little"))
    assert moves == (529, bytes.fromhex("983a3cf6bc02d4fe"))  # 15000, -2500, 700, -300
    assert check[0] == 530
    assert check[1][:4].hex() == "07120200"


def test_what_is_said_is_heard() -> None:
    agent, controller = Decoder(FRAMES, "agent"), Decoder(FRAMES, "controller")
    status = Status(3, COMMANDED, True, True, frozenset({"water in the hull", "emergency stop pressed"}))
    assert agent.take(*FRAMES.status(status)) == status
    battery = Battery(9, 73.0, 12.34, -5.5)
    heard = agent.take(*FRAMES.battery(battery))
    assert isinstance(heard, Battery)
    assert (heard.percent, heard.voltage_v, heard.current_a) == pytest.approx((73.0, 12.34, -5.5))
    assert controller.take(*FRAMES.watchdog(200, False)) == Watchdog(200, False)
    thrusts = controller.take(*FRAMES.thrust(Thrusts(1.0, -2.0, 3.0, -4.0)))
    assert isinstance(thrusts, Thrusts)
    assert (thrusts.rear_port, thrusts.side_starboard) == pytest.approx((1.0, -4.0))


def test_a_navigation_set_is_heard_as_a_whole() -> None:
    decoder = Decoder(FRAMES, "agent")
    place, moves, check = FRAMES.navigation(HERE)
    assert decoder.take(*place) is None
    assert decoder.take(*moves) is None
    nav = decoder.take(*check)
    assert isinstance(nav, Navigation)
    for field in ("lat_deg", "lon_deg", "heading_rad", "yaw_rate_radps", "v_north_mps", "v_east_mps"):
        assert getattr(nav, field) == pytest.approx(getattr(HERE, field), abs=1e-6)


@pytest.mark.parametrize("lost", [0, 1])
def test_without_one_of_its_frames_a_set_counts_for_nothing(lost: int) -> None:
    decoder = Decoder(FRAMES, "agent")
    frames = [*FRAMES.navigation(HERE)]
    del frames[lost]
    assert [decoder.take(*frame) for frame in frames] == [None, None]
    assert decoder.counts.check == 1


def test_frames_of_two_sets_are_not_put_together() -> None:
    from msgspec.structs import replace

    decoder = Decoder(FRAMES, "agent")
    first, second = FRAMES.navigation(HERE), FRAMES.navigation(replace(HERE, counter=8, lat_deg=44.39))
    for frame in (first[0], second[1]):
        decoder.take(*frame)
    assert decoder.take(*second[2]) is None


def test_what_is_not_available_is_nan_and_a_2d_fix_is_none() -> None:
    from msgspec.structs import replace

    decoder = Decoder(FRAMES, "agent")
    gone = replace(HERE, lat_deg=math.nan, heading_rad=math.nan, yaw_rate_radps=math.nan)
    for frame in FRAMES.navigation(gone)[:2]:
        decoder.take(*frame)
    nav = decoder.take(*FRAMES.navigation(gone)[2])
    assert isinstance(nav, Navigation)
    assert all(math.isnan(x) for x in (nav.lat_deg, nav.lon_deg, nav.heading_rad, nav.yaw_rate_radps, nav.v_north_mps))
    flat = replace(HERE, counter=8, fix=FIX_2D)
    nav = [decoder.take(*frame) for frame in FRAMES.navigation(flat)][2]
    assert isinstance(nav, Navigation)
    assert math.isnan(nav.lat_deg)
    assert nav.heading_rad == pytest.approx(1.5)


@pytest.mark.parametrize(
    "wrong",
    [{"lat_deg": 91.0}, {"lat_deg": 0.0, "lon_deg": 0.0}, {"v_north_mps": 16.0}, {"yaw_rate_radps": 3.1}],
    ids=str,
)
def test_a_whole_set_that_cannot_be_is_refused(wrong: dict[str, float]) -> None:
    from msgspec.structs import replace

    decoder = Decoder(FRAMES, "agent")
    assert [decoder.take(*frame) for frame in FRAMES.navigation(replace(HERE, **wrong))] == [None] * 3
    assert decoder.counts.implausible == 1


def test_a_sender_that_is_stuck_is_heard_once() -> None:
    decoder = Decoder(FRAMES, "agent")
    heard = [decoder.take(*frame) for _ in range(5) for frame in FRAMES.navigation(HERE)]
    assert sum(one is not None for one in heard) == 1
    assert decoder.counts.repeated == 4


def test_every_flipped_bit_is_found() -> None:
    status = Status(3, COMMANDED, False, True)
    for identifier, payload in (FRAMES.status(status), FRAMES.thrust(Thrusts(1.0, 2.0, 3.0, 4.0))):
        for bit in range(8 * len(payload)):
            flipped = bytearray(payload)
            flipped[bit // 8] ^= 1 << bit % 8
            decoder = Decoder(FRAMES, "agent" if identifier == 512 else "controller")
            assert decoder.take(identifier, bytes(flipped)) is None
            assert decoder.counts.check == 1


def test_a_frame_does_not_pass_for_another() -> None:
    decoder = Decoder(FRAMES, "agent")
    _, payload = FRAMES.status(Status(1, 2, False, False))
    assert decoder.take(544, payload) is None
    assert decoder.counts.check == 1


def test_ten_thousand_random_and_mutated_frames() -> None:
    result = attack(10_000, random.Random(1))
    assert result.crashes == 0
    assert result.wrong_positions == 0
    assert result.counted == 10_000
    assert result.good_refused == 0
    assert result.good_heard > 100


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda text: text.replace("BO_ 544 Battery", "BO_ 544 Cells"),
            "no message 'Battery'; expected Watchdog, Thrust",
        ),
        (lambda text: text.replace("SG_ Percent", "SG_ Level"), "Battery has no signal Percent"),
        (lambda text: text.replace("BO_ 257 Thrust: 8", "BO_ 257 Thrust: 12"), "Thrust has 12 bytes; expected 8"),
        (lambda text: "<html>", "not a DBC"),
    ],
    ids=["message", "signal", "length", "html"],
)
def test_a_wrong_dbc_is_refused_with_what_is_wrong(tmp_path: Path, change: object, message: str) -> None:
    wrong = tmp_path / "mine.dbc"
    wrong.write_text(change(SHIPPED.read_text()))  # type: ignore[operator]
    with pytest.raises(ConfigError) as caught:
        Frames(str(wrong))
    assert f"driver.can.dbc '{wrong}': " in str(caught.value)
    assert message in str(caught.value)


def test_a_dbc_that_is_not_there_is_named() -> None:
    with pytest.raises(ConfigError, match=r"driver.can.dbc '/none.dbc': no such file; expected a DBC"):
        Frames("/none.dbc")


def test_another_controllers_identifiers_are_taken_from_its_dbc(tmp_path: Path) -> None:
    mine = tmp_path / "mine.dbc"
    mine.write_text(SHIPPED.read_text().replace("BO_ 256 Watchdog", "BO_ 80 Watchdog").replace(" 256 ", " 80 "))
    assert Frames(str(mine)).watchdog(5, True)[0] == 80
