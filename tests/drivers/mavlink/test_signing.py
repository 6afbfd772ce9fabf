"""Signed MAVLink between driver and autopilot."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

import pytest

from fleet.drivers.mavlink.signing import Signing
from fleet.drivers.mavlink.words import dialect
from fleet.errors import ConfigError
from tests.drivers.mavlink.bench import BEGIN_NS, Bench

KEY = hashlib.sha256(b"a long passphrase").digest()
YEAR_NS = 365 * 86_400 * 1_000_000_000


@pytest.fixture
def passphrase(tmp_path: Path) -> Path:
    file = tmp_path / "key"
    file.write_text("a long passphrase\n")
    return file


def test_with_the_same_key_the_boat_is_driven(bench_of: Callable[..., Bench], passphrase: Path) -> None:
    bench = bench_of(key=KEY, signing_key=str(passphrase))
    bench.launch()
    bench.run(5.0, (0.5, 0.0))
    assert bench.state.u > 0.3


@pytest.mark.parametrize("ours", ["", "another"])
def test_without_the_key_or_with_another_nothing_is_obeyed(
    bench_of: Callable[..., Bench], tmp_path: Path, ours: str
) -> None:
    file = tmp_path / "key"
    file.write_text("another")
    bench = bench_of(key=KEY, signing_key=str(file) if ours else "")
    bench.run(5.0)
    bench.driver.obeyed("launch")
    bench.run(5.0, (0.5, 0.0))
    assert (bench.mode, bench.rover.armed) == ("MANUAL", False)


def test_a_forged_frame_without_a_signature_is_not_believed(bench_of: Callable[..., Bench], passphrase: Path) -> None:
    bench = bench_of(key=b"", signing_key=str(passphrase))
    bench.run(3.0)
    assert not bench.known
    assert bench.reading.trouble.startswith("no autopilot")


def test_timestamps_never_go_back_though_the_clock_does(passphrase: Path) -> None:
    def begun(now_ns: int) -> int:
        codec = dialect().MAVLink(None)
        Signing(str(passphrase)).begin((codec,), now_ns)
        stamp: int = codec.signing.timestamp
        return stamp

    first = begun(BEGIN_NS)
    assert begun(BEGIN_NS - YEAR_NS) > first
    assert begun(0) > first


def test_a_file_without_a_key_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty").write_text(" \n")
    with pytest.raises(ConfigError, match=r"is empty; expected a file with a passphrase"):
        Signing(str(tmp_path / "empty"))
    with pytest.raises(ConfigError, match=r"No such file or directory; expected a file with a passphrase"):
        Signing(str(tmp_path / "none"))
