"""SCIP 2.0, byte for byte: the specification's examples, every encoding, and whatever may be wrong with a reply."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.drivers.lidar import scip
from fleet.drivers.lidar.scip import Decoder, Measurement, Model, Reply, Request
from fleet.drivers.lidar.words import HARDWARE, in_words
from fleet.sensing.scan import unpacked
from fleet.sim.scanner.speech import measurement_bytes, model_lines

URG = Model("URG-04LX(Hokuyo Automatic Co., Ltd.)", 20, 5600, 1024, 44, 725, 384, 600)
UTM = Model("UTM-30LX-EW", 23, 60000, 1440, 0, 1080, 540, 2400)
EVERY = ("MD", "MS", "ME", "GD", "GS", "GE")


def listening(request: Request, model: Model = UTM) -> Decoder:
    decoder = Decoder()
    decoder.expect(request, model)
    return decoder


def distances(said: Reply | Measurement) -> list[int]:
    """In millimetres; -1: none."""
    assert isinstance(said, Measurement)
    return [-1 if math.isnan(metres) else round(metres * 1e3) for metres in unpacked(said.ranges)]


@pytest.mark.parametrize(("value", "text"), [(1234, b"CB"), (5432, b"1Dh"), (16_000_000, b"m2@0")])
def test_numbers_of_two_three_and_four_characters_are_as_in_the_specification(value: int, text: bytes) -> None:
    assert scip.encode(value, len(text)) == text
    assert scip.decode(text) == value


@given(st.integers(2, 4), st.data())
def test_every_number_comes_back(characters: int, data: st.DataObject) -> None:
    value = data.draw(st.integers(0, (1 << 6 * characters) - 1))
    assert scip.decode(scip.encode(value, characters)) == value


def test_sums_are_those_that_scanners_send() -> None:
    assert [chr(scip.checksum(line)) for line in (b"00", b"99", b"0E", b"DMAX:5600", b"AMAX:725")] == [*"Pbe_o"]


def test_what_a_scanner_says_of_itself_is_read_with_and_without_the_semicolon_in_the_sum() -> None:
    lines = model_lines(URG)
    for part in (b"", b";"):
        told = b"".join(line + b";" + bytes([scip.checksum(line + part)]) + b"\n" for line in lines)
        (reply,) = Decoder().feed(b"PP\n00P\n" + told + b"\n")
        assert isinstance(reply, Reply)
        assert scip.model(reply) == URG


def test_a_remark_that_the_firmware_leaves_out_of_the_sum_is_no_error() -> None:
    line = b"STAT:sensor works well"
    whole = line + b"<-(ok)"
    (reply,) = Decoder().feed(b"II\n00P\n" + whole + b";" + bytes([scip.checksum(line)]) + b"\n\n")
    assert isinstance(reply, Reply)
    assert reply.table["STAT"].startswith("sensor works well")


@pytest.mark.parametrize("wrong", ["ARES:0", "AMIN:726", "DMAX:10", "SCAN:0", "AFRT:9999", "AMAX:x", "DMIN:-5"])
def test_a_scanner_that_cannot_be_is_none(wrong: str) -> None:
    table = dict(line.decode().split(":", 1) for line in model_lines(URG))
    key, value = wrong.split(":")
    table[key] = value
    assert scip.model(Reply("PP", "00", tuple(f"{k}:{v}" for k, v in table.items()))) is None
    del table[key]
    assert scip.model(Reply("PP", "00", tuple(f"{k}:{v}" for k, v in table.items()))) is None


def test_steps_are_counted_to_port_and_bearings_to_starboard() -> None:
    assert UTM.angle(540) == 0.0
    assert UTM.angle(0) == pytest.approx(math.radians(135.0))  # the first step is on the starboard quarter
    assert UTM.angle(1080) == pytest.approx(math.radians(-135.0))
    assert UTM.step(math.radians(90.0)) == 180
    assert UTM.step(math.radians(-180.0)) == 1080


def test_commands_are_as_in_the_specification() -> None:
    assert Request("MD", 10, 750, 1, 0, 0).line() == b"MD0010075001000\n"
    assert Request("MS", 44, 725, 3, 2, 5).line() == b"MS0044072503205\n"
    assert Request("GS", 44, 725, 1).line() == b"GS0044072501\n"
    assert [scip.command("TM", "0"), scip.command("QT")] == [b"TM0\n", b"QT\n"]


@pytest.mark.parametrize("command", EVERY)
@pytest.mark.parametrize("steps", [(0, 1080), (540, 541), (0, 20), (0, 31), (0, 63)])
def test_distances_come_back_in_every_encoding_and_length(command: str, steps: tuple[int, int]) -> None:
    request = Request(command, *steps)
    rng = random.Random(command + str(steps))
    most = 4094 if command[1] == "S" else 60_000
    sent = [rng.randrange(23, most + 1) for _ in range(request.values)]
    decoder = listening(request)
    (said,) = decoder.feed(measurement_bytes(request, 16_777_215, sent, left=7))
    assert distances(said) == sent
    assert isinstance(said, Measurement)
    assert said.ms == 16_777_215
    assert said.left == (7 if request.again else 0)
    assert decoder.counts == scip.Counts(scans=1)


def test_error_codes_and_distances_that_the_scanner_cannot_measure_are_no_return() -> None:
    request = Request("MD", 0, 8)
    codes = [0, 1, 6, 7, 19, 22, 65_533, 60_001, 1000]
    (said,) = listening(request).feed(measurement_bytes(request, 0, codes))
    assert distances(said) == [-1] * 8 + [1000]
    short = Request("MS", 0, 1)
    (said,) = listening(short).feed(measurement_bytes(short, 0, [4095, 4094]))
    assert distances(said) == [-1, 4094]  # 4095 is all that is farther


@given(st.integers(1, 99), st.integers(1, 400))
def test_clusters_give_one_distance_for_so_many_steps(cluster: int, more: int) -> None:
    request = Request("MD", 5, 5 + more, cluster)
    assert request.values == math.ceil((more + 1) / cluster)


@given(st.lists(st.integers(1, 400), max_size=40))
def test_it_does_not_matter_in_what_pieces_bytes_arrive(cuts: list[int]) -> None:
    request = Request("MD", 0, 100)
    sent = [*range(1000, 1101)]
    stream = b"MD0000010001000\n00P\n\n" + measurement_bytes(request, 5, sent) + b"QT\n00P\n\n"
    decoder = listening(request)
    found: list[Reply | Measurement] = []
    for cut in cuts:
        found += decoder.feed(stream[:cut])
        stream = stream[cut:]
    found += decoder.feed(stream)
    assert [type(one) for one in found] == [Reply, Measurement, Reply]
    assert distances(found[1]) == sent


def test_a_measurement_that_was_not_asked_for_is_foreign() -> None:
    asked, other = Request("MD", 0, 100), Request("MD", 1, 101)
    frame = measurement_bytes(other, 5, [1000] * 101)
    decoder = listening(asked)
    assert decoder.feed(frame) == []
    assert Decoder().feed(frame) == []
    assert decoder.counts == scip.Counts(foreign=1)


def test_a_line_that_is_missing_doubled_or_cut_is_counted_and_no_scan() -> None:
    request = Request("MD", 0, 100)
    frame = measurement_bytes(request, 5, [1000] * 101)
    lines = frame[:-2].split(b"\n")
    for wrong in (lines[:3] + lines[4:], [*lines[:4], lines[3], *lines[4:]], [*lines[:-1], lines[-1][:-4]], lines[:2]):
        decoder = listening(request)
        assert decoder.feed(b"\n".join(wrong) + b"\n\n") == []
        assert decoder.counts.refused == 1
        (said,) = decoder.feed(frame)  # and the next one is taken
        assert distances(said)[0] == 1000


def test_every_single_wrong_bit_is_noticed() -> None:
    request = Request("MD", 0, 44)
    sent = [*range(5000, 5045)]
    frame = measurement_bytes(request, 5, sent)
    for k in range(8 * len(frame)):
        wrong = bytearray(frame)
        wrong[k // 8] ^= 1 << k % 8
        decoder = listening(request)
        for said in decoder.feed(bytes(wrong) + b"\n\n"):
            if isinstance(said, Measurement):
                assert distances(said) == sent  # of what has no sum, only the number of scans left may differ
                assert said.ms == 5


def test_bytes_without_an_end_are_thrown_away_and_counted() -> None:
    decoder = Decoder()
    assert decoder.feed(b"x" * 70_000) == []
    assert decoder.counts == scip.Counts(overflow=1)
    assert len(decoder.feed(b"\n\nQT\n00P\n\n")) == 1


@pytest.mark.parametrize(
    ("command", "status", "words"),
    [
        ("MD", "55", HARDWARE),
        ("MD", "33", "stopped to look for an error"),
        ("GD", "10", "denied: the laser is off, or the state is another"),
        ("TM", "04", "not adjusting"),
        ("BM", "01", "laser cannot be switched on"),
        ("VV", "0E", "undefined command"),
        ("QT", "ZZ", "status ZZ"),
    ],
)
def test_every_status_has_words(command: str, status: str, words: str) -> None:
    assert in_words(command, status) == words
