"""What starts real processes runs on one worker, one after the other: it needs the time of the machine."""

from __future__ import annotations

import pytest


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put every test that is marked `sails` into one group."""
    for item in items:
        if item.get_closest_marker("sails") is not None and item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group("sails"))
