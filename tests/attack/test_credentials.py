"""Wrong credentials against live agents: none obeyed, each named; the operator's launch is obeyed.

Over QUIC with each boat a router here; `python -m tests.attack.credentials` does all four, FLEET_CREDENTIALS_ALL here.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.attack.credentials import attack

ALL = (("routed", "quic"), ("hub", "tls"), ("routed", "tls"), ("hub", "quic"))
pytestmark = [pytest.mark.sails, pytest.mark.timeout(300)]


@pytest.mark.parametrize(("topology", "transport"), ALL if os.environ.get("FLEET_CREDENTIALS_ALL") else ALL[:1])
def test_only_the_operator_is_obeyed_and_each_of_the_others_is_named(
    tmp_path: Path, topology: str, transport: str
) -> None:
    rows = attack(tmp_path, topology, transport)  # type: ignore[arg-type]
    assert [row.attack for row in rows if row.obeyed] == ["the operator launches"]
    assert [row.attack for row in rows if not row.line] == []
