"""A row of the table of `docs/failsafes.md` with real processes; all of it: `python -m tests.proofs.dead_man`."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.proofs.dead_man import LAYERS, measure

PAGE = Path(__file__).parents[2] / "docs" / "failsafes.md"


@pytest.mark.sails
def test_a_killed_agent_leaves_no_command_for_longer_than_the_controllers_watchdog_and_a_second() -> None:
    row = measure("can", LAYERS[0], look_s=3.0)
    assert 0.0 < row.drove_s <= row.layer.limit_s["can"] + 1.0, row
    assert row.again_s == 0.0
    assert row.then == "controller: standby"


@pytest.mark.parametrize("layer", LAYERS, ids=lambda layer: layer.what)
def test_the_page_has_a_row_of_each_layer_and_each_driver_that_kept_its_limit(layer: object) -> None:
    for kind, limit_s in layer.limit_s.items():  # type: ignore[attr-defined]
        row = next(
            line
            for line in PAGE.read_text().splitlines()
            if line.startswith(f"| `{kind}` | {layer.what} |")  # type: ignore[attr-defined]
        )
        cells = [cell.strip() for cell in row.split("|")]
        assert cells[4] == f"{limit_s:g} s"
        assert float(cells[5].removesuffix(" s")) <= limit_s + 1.0
