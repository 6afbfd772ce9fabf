"""One run for the tests of this folder."""

from __future__ import annotations

import pytest
from sailed import sail

from fleet.recording.runs import Run


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """An overtaking as a simulator would record it."""
    return sail(tmp_path_factory.mktemp("runs") / "20261122T120000Z-overtaking")
