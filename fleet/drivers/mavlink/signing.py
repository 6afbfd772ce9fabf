"""Signed MAVLink: the key from a file, and a timestamp that never goes back, whatever the machine's clock does.

The key is SHA-256 of the file's text without the white space around it, as ground stations make it of a passphrase.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from pathlib import Path
from typing import Any

from fleet.errors import ConfigError

EPOCH_S = 1_420_070_400  # 2015-01-01 UTC
A_SECOND = 100_000  # timestamps count 10 us
KEPT_S = 60.0  # between two writes of the timestamp


def _no_key(option: str, where: str, why: str) -> ConfigError:
    return ConfigError(f"{option} {where!r}: {why}; expected a file with a passphrase")


class Signing:
    """Signs what we say, and lets only what is signed with the same key be heard."""

    def __init__(self, where: str, option: str = "driver.mavlink.signing_key") -> None:
        """ConfigError when the file holds no key; option: what named it."""
        self._file = Path(where)
        try:
            text = self._file.read_text(encoding="utf-8").strip()
        except (OSError, UnicodeDecodeError) as error:
            words = getattr(error, "strerror", None) or "not text"
            raise _no_key(option, where, words) from None
        if not text:
            raise _no_key(option, where, "is empty")
        self._key = hashlib.sha256(text.encode()).digest()
        self._stamp_file = self._file.with_name(self._file.name + ".stamp")
        self._kept = 0
        with contextlib.suppress(OSError, ValueError):
            self._kept = int(self._stamp_file.read_text(encoding="ascii"))

    def begin(self, codecs: tuple[Any, ...], now_ns: int) -> None:
        """Codecs of the dialect sign and check from now on."""
        for codec in codecs:
            codec.signing.secret_key = self._key
            codec.signing.sign_outgoing = True
            codec.signing.timestamp = self._kept + int(KEPT_S * A_SECOND) if self._kept else 0
        self.follow(codecs, now_ns)

    def follow(self, codecs: tuple[Any, ...], now_ns: int) -> None:
        """Timestamps follow the clock, never back; once a minute they are written down."""
        newest = max(0, now_ns // 10_000 - EPOCH_S * A_SECOND)
        for codec in codecs:
            newest = max(newest, codec.signing.timestamp)
        for codec in codecs:
            codec.signing.timestamp = newest
        if newest - self._kept >= KEPT_S * A_SECOND:
            self._kept = newest
            with contextlib.suppress(OSError):  # the clock alone has to do then
                beside = self._stamp_file.with_name(self._stamp_file.name + ".new")
                beside.write_text(str(newest), encoding="ascii")
                os.replace(beside, self._stamp_file)
