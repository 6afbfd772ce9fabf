"""Why a formation cannot be sailed: one reason."""

from __future__ import annotations

from msgspec import Struct

CRUISE_MARGIN_MPS = 0.1  # what a boat needs above and below cruise to correct its place


class Misfit(Struct, frozen=True):
    """Why a formation cannot be sailed."""

    key: str
    """`spacing_m`, `cruise_mps`, `lateral_m`, `pattern` or `slots`: the value that would have to change."""
    text: str
