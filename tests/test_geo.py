"""The local plane: against pymap3d, and there and back."""

from __future__ import annotations

import numpy as np
import pymap3d
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet.errors import UsageError
from fleet.geo import Datum, plane_of, to_geographic, to_local

DATUMS = [Datum(44.1, 9.8), Datum(-60.0, 179.99), Datum(0.0, 0.0), Datum(78.2, -15.6), Datum(-33.9, -179.999)]
metres = st.floats(-10_000.0, 10_000.0)


@pytest.mark.parametrize("datum", DATUMS, ids=str)
def test_a_position_within_10_km_lands_where_pymap3d_puts_it(datum: Datum) -> None:
    for x in np.linspace(-7000.0, 7000.0, 7).tolist():
        for y in np.linspace(-7000.0, 7000.0, 7).tolist():
            lat_deg, lon_deg = to_geographic(datum, x, y)
            n, e, _ = pymap3d.geodetic2ned(lat_deg, lon_deg, 0.0, datum.lat_deg, datum.lon_deg, 0.0)
            assert to_local(datum, lat_deg, lon_deg) == pytest.approx((n, e), abs=0.01)


@given(metres, metres, st.sampled_from(DATUMS))
@settings(deadline=None, derandomize=True)
def test_there_and_back_is_the_same_place_to_a_tenth_of_a_millimetre(x: float, y: float, datum: Datum) -> None:
    assert to_local(datum, *to_geographic(datum, x, y)) == pytest.approx((x, y), abs=1e-4)


def test_the_datum_is_the_origin_and_a_minute_of_latitude_a_nautical_mile() -> None:
    assert to_local(Datum(45.0, 9.0), 45.0, 9.0) == pytest.approx((0.0, 0.0), abs=1e-8)
    x, y = to_local(Datum(45.0, 9.0), 45.0 + 1.0 / 60.0, 9.0)
    assert x == pytest.approx(1852.0, abs=1.0)
    assert y == pytest.approx(0.0, abs=1e-6)


def test_east_is_positive_across_the_antimeridian() -> None:
    x, y = to_local(Datum(-20.0, 179.999), -20.0, -179.999)
    assert y == pytest.approx(209.0, abs=1.0)
    _, lon_deg = to_geographic(Datum(-20.0, 179.999), x, y)
    assert lon_deg == pytest.approx(-179.999, abs=1e-9)


def test_a_lane_gets_the_bits_of_a_boat() -> None:
    plane = plane_of(DATUMS[0])
    x, y = np.random.default_rng(1).uniform(-9000.0, 9000.0, (2, 500))
    lat, lon = plane.to_geographic(x, y)
    alone = [plane.to_geographic(*p) for p in zip(x.tolist(), y.tolist(), strict=True)]
    assert list(zip(lat.tolist(), lon.tolist(), strict=True)) == alone
    back = [plane.to_local(*p) for p in alone]
    assert [v.tolist() for v in plane.to_local(lat, lon)] == [list(v) for v in zip(*back, strict=True)]


@pytest.mark.parametrize("wrong", [Datum(91.0, 0.0), Datum(0.0, 181.0), Datum(float("nan"), 0.0)], ids=str)
def test_what_is_no_position_is_refused_with_its_values(wrong: Datum) -> None:
    with pytest.raises(UsageError, match=r"datum is no position: lat_deg .*; expected within \[-90, 90\]"):
        plane_of(wrong)
