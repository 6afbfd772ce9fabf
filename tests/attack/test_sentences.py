"""A small sample of the attack on the readers of sentences; the whole of it is `python -m tests.attack.sentences`."""

from __future__ import annotations

import random

import pytest

from fleet.drivers.nmea import codec
from tests.attack import sentences


@pytest.mark.parametrize("name", sorted(sentences.ATTACKS))
def test_nothing_crashes_nothing_wrong_is_believed_and_every_line_is_counted(name: str) -> None:
    result = sentences.ATTACKS[name](6000, random.Random(3))
    assert (result.crashes, result.wrong) == (0, 0)
    assert result.counted == result.lines == 6000
    assert result.whole_believed > 500


def test_the_attack_would_notice_a_reader_that_does_not_look_at_checksums(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sentences, "honest", lambda line, start: False)
    unframed = codec.unframed

    def trusting(line: bytes, start: bytes = b"$") -> list[str]:
        body = line[1:].rpartition(b"*")[0] or line[1:]
        return body.decode("ascii", "replace").split(",") if line.startswith(start) else unframed(line, start)

    monkeypatch.setattr(codec, "unframed", trusting)
    assert sentences.nmea(6000, random.Random(3)).wrong > 0  # few: the other rules stop most
