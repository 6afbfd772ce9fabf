"""Arithmetic for floats and for arrays, with equal bits.

A law is written once over these functions and serves one boat (plain floats) and a batch (one array per variable, boats
along the last axis). Built only from operations that IEEE 754 rounds the same everywhere: + - * / sqrt, comparisons,
selection. `sin cos atan2 tanh` of the libraries differ between processors and array lengths, so they have twins here.
What a float takes by `if`, a lane selects by `where`; the arithmetic is shared, or the same in `ops_lanes`. numpy is
imported only where an array appears, never by an agent's tick.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, TypeVarTuple, Unpack, overload

import msgspec

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

FloatArray: TypeAlias = "NDArray[np.float64]"
BoolArray: TypeAlias = "NDArray[np.bool_]"
Bool: TypeAlias = "bool | BoolArray"
R = TypeVar("R", float, "FloatArray")
"""A value of one boat (float) or of a batch (array, boats along the last axis)."""
T = TypeVar("T")
Ts = TypeVarTuple("Ts")

PI = math.pi
TWO_PI = 2.0 * math.pi
BIG = 1.5 * 2.0**52  # adding and taking it away rounds to the nearest integer

# pi/2 in three parts: the first two have 33 bits each, so that n times a part is exact for |n| < 2**20
_P1 = 1.57079632673412561417e00
_P2 = 6.07710050630396597660e-11
_P3 = 2.02226624879595063154e-21
_TWO_OVER_PI = 2.0 / math.pi
_LOG2E = 1.0 / math.log(2.0)
_LN2_HIGH = 6.93147180369123816490e-01  # ln 2 in two parts, the first with 33 bits
_LN2_LOW = 1.90821492927058770002e-10
_ATAN_AT = tuple(math.atan(k / 4.0) for k in range(5))
_S3, _S5, _S7, _S9, _S11, _S13, _S15 = (  # Taylor: below 5e-17 on [-pi/4, pi/4]
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362880.0,
    -1.0 / 39916800.0,
    1.0 / 6227020800.0,
    -1.0 / 1307674368000.0,
)
_C2, _C4, _C6, _C8, _C10, _C12, _C14, _C16 = (
    -0.5,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40320.0,
    -1.0 / 3628800.0,
    1.0 / 479001600.0,
    -1.0 / 87178291200.0,
    1.0 / 20922789888000.0,
)
_E3, _E4, _E5, _E6, _E7, _E8, _E9, _E10, _E11, _E12, _E13 = (1.0 / math.factorial(k) for k in range(3, 14))


@overload
def where(cond: bool, a: float, b: float) -> float: ...
@overload
def where(cond: BoolArray, a: FloatArray | float, b: FloatArray | float) -> FloatArray: ...
def where(cond: Any, a: Any, b: Any) -> Any:
    """a where cond holds, b elsewhere; both sides must be finite."""
    if cond is True:
        return a
    if cond is False:
        return b
    import fleet.ops_lanes as lanes  # `from fleet import` would take 0.4 us more in every call

    return lanes.where(cond, a, b)


@overload
def flag(cond: bool, like: float) -> float: ...
@overload
def flag(cond: BoolArray, like: FloatArray) -> FloatArray: ...
def flag(cond: Any, like: Any) -> Any:
    """1.0 where cond holds, else 0.0: how flags and latches are kept."""
    if cond is True:
        return 1.0 if type(like) is float else full(like, 1.0)
    if cond is False:
        return 0.0 if type(like) is float else zero(like)
    return cond.astype(float)


@overload
def minimum(a: float, b: float) -> float: ...
@overload
def minimum(a: FloatArray, b: FloatArray | float) -> FloatArray: ...
@overload
def minimum(a: float, b: FloatArray) -> FloatArray: ...
def minimum(a: Any, b: Any) -> Any:
    """The smaller one; value first, limit second: a NaN in `a` stays."""
    cond = b < a
    if cond is True:
        return b
    if cond is False:
        return a
    import fleet.ops_lanes as lanes

    if type(b) is float and b != 0.0:  # zeros of either sign are equal, and processors differ in which one they take
        return lanes.minimum(a, b)
    return lanes.where(cond, b, a)


@overload
def maximum(a: float, b: float) -> float: ...
@overload
def maximum(a: FloatArray, b: FloatArray | float) -> FloatArray: ...
@overload
def maximum(a: float, b: FloatArray) -> FloatArray: ...
def maximum(a: Any, b: Any) -> Any:
    """The larger one; value first, limit second: a NaN in `a` stays."""
    cond = b > a
    if cond is True:
        return b
    if cond is False:
        return a
    import fleet.ops_lanes as lanes

    if type(b) is float and b != 0.0:
        return lanes.maximum(a, b)
    return lanes.where(cond, b, a)


@overload
def lesser(a: float, b: float) -> float: ...
@overload
def lesser(a: FloatArray, b: FloatArray) -> FloatArray: ...
def lesser(a: Any, b: Any) -> Any:
    """The smaller one of two numbers that are neither NaN nor -0.0, as squares are: a fifth of what `minimum` costs."""
    if type(a) is float:
        return b if b < a else a
    import numpy as np

    return np.minimum(a, b)


@overload
def greater(a: float, b: float) -> float: ...
@overload
def greater(a: FloatArray, b: FloatArray) -> FloatArray: ...
def greater(a: Any, b: Any) -> Any:
    """The larger one of two numbers that are neither NaN nor -0.0."""
    if type(a) is float:
        return b if b > a else a
    import numpy as np

    return np.maximum(a, b)


@overload
def clip(x: float, low: float, high: float) -> float: ...
@overload
def clip(x: FloatArray, low: FloatArray | float, high: FloatArray | float) -> FloatArray: ...
def clip(x: Any, low: Any, high: Any) -> Any:
    """x held within [low, high]; a NaN stays."""
    if type(x) is float:  # `minimum(maximum(x, low), high)`, without the calls
        x = low if low > x else x
        return high if high < x else x
    if type(low) is float and type(high) is float and low != 0.0 != high:
        import numpy as np

        return np.minimum(np.maximum(x, low), high)
    return minimum(maximum(x, low), high)


@overload
def sqrt(x: float) -> float: ...
@overload
def sqrt(x: FloatArray) -> FloatArray: ...
def sqrt(x: Any) -> Any:
    """Square root of x >= 0."""
    if type(x) is float:
        return math.sqrt(x)
    import numpy as np

    return np.sqrt(x)


def hypot(x: R, y: R) -> R:
    """Length of (x, y)."""
    square = x * x + y * y
    return math.sqrt(square) if type(square) is float else sqrt(square)


@overload
def zero(like: float) -> float: ...
@overload
def zero(like: FloatArray) -> FloatArray: ...
def zero(like: Any) -> Any:
    """0.0, or an array of zeros like `like`: the start of a fold."""
    if type(like) is float:
        return 0.0
    import fleet.ops_lanes as lanes

    return lanes.full(like.shape, 0.0)


@overload
def full(like: float, value: float) -> float: ...
@overload
def full(like: FloatArray, value: float) -> FloatArray: ...
def full(like: Any, value: float) -> Any:
    """`value`, or an array of it like `like`."""
    if type(like) is float:
        return value
    import fleet.ops_lanes as lanes

    return lanes.full(like.shape, value)


def floor(x: R) -> R:
    """Largest whole number not above x, |x| < 2**51."""
    nearest = (x + BIG) - BIG
    return where(nearest > x, nearest - 1.0, nearest)


@overload
def finite(x: float) -> bool: ...
@overload
def finite(x: FloatArray) -> BoolArray: ...
def finite(x: Any) -> Any:
    """Neither NaN nor infinite."""
    return abs(x) < math.inf


def every(cond: Bool) -> bool:
    """True where the condition holds in every lane."""
    if cond is True or cond is False:
        return cond
    import numpy as np

    return bool(np.count_nonzero(cond) == cond.size)  # a third of what `all` costs


def some(cond: Bool) -> bool:
    """True where the condition holds in at least one lane."""
    if cond is True or cond is False:
        return cond
    import numpy as np

    return bool(np.count_nonzero(cond))


@overload
def no(cond: bool) -> bool: ...
@overload
def no(cond: BoolArray) -> BoolArray: ...
def no(cond: Any) -> Any:
    """Not: the operator `~` would turn True into -2."""
    return cond ^ True


@overload
def settled(cond: bool, expected: bool) -> bool: ...
@overload
def settled(cond: BoolArray, expected: bool) -> BoolArray: ...
def settled(cond: Any, expected: bool) -> Any:
    """The same condition, as one bool where every lane is as expected: whatever hangs on it then costs nothing."""
    if cond is True or cond is False:
        return cond
    return expected if (every(cond) if expected else not some(cond)) else cond


@overload
def sincos(x: float) -> tuple[float, float]: ...
@overload
def sincos(x: FloatArray) -> tuple[FloatArray, FloatArray]: ...
def sincos(x: Any) -> Any:
    """Sine and cosine of x [rad]; error below 3e-16 for |x| < 1e5."""
    if type(x) is not float and getattr(x, "ndim", None):
        import fleet.ops_lanes as lanes

        return lanes.sincos(x)
    n = (x * _TWO_OVER_PI + BIG) - BIG
    r = ((x - n * _P1) - n * _P2) - n * _P3
    z = r * r
    sin_r = r + r * z * (_S3 + z * (_S5 + z * (_S7 + z * (_S9 + z * (_S11 + z * (_S13 + z * _S15))))))
    cos_r = 1.0 + z * (_C2 + z * (_C4 + z * (_C6 + z * (_C8 + z * (_C10 + z * (_C12 + z * (_C14 + z * _C16)))))))
    quarter = n - 4.0 * ((n * 0.25 + BIG) - BIG)  # -2, -1, 0, 1, 2
    if quarter == 0.0:
        return sin_r, cos_r
    if quarter == 1.0:
        return cos_r, -sin_r
    if quarter == -1.0:
        return -cos_r, sin_r
    return -sin_r, -cos_r


@overload
def atan2(y: float, x: float) -> float: ...
@overload
def atan2(y: FloatArray, x: FloatArray | float) -> FloatArray: ...
@overload
def atan2(y: float, x: FloatArray) -> FloatArray: ...
def atan2(y: Any, x: Any) -> Any:
    """Angle of (x, y) in [-pi, pi] [rad]; 0 for (0, 0). Error below 5e-16."""
    a, b = abs(y), abs(x)
    steep = a > b
    if steep is not True and steep is not False and steep.ndim:
        import fleet.ops_lanes as lanes

        return lanes.atan2(y, x)
    top, bottom = (b, a) if steep else (a, b)
    t = top / (1.0 if bottom <= 0.0 else bottom)  # a NaN stays
    k = (t * 4.0 + BIG) - BIG
    c = k * 0.25
    w = (t - c) / (1.0 + c * t)
    z = w * w
    series = 1.0 / 9.0 + z * (-1.0 / 11.0 + z * (1.0 / 13.0 + z * (-1.0 / 15.0)))
    small = w + w * z * (-1.0 / 3.0 + z * (1.0 / 5.0 + z * (-1.0 / 7.0 + z * series)))
    angle = (_ATAN_AT[int(k)] if k == k else k) + small  # noqa: PLR0124 - NaN has no row
    if steep:
        angle = PI / 2.0 - angle
    if x < 0.0:
        angle = PI - angle
    return -angle if y < 0.0 else angle


def wrap(angle: R) -> R:
    """Same angle, in [-pi, pi] [rad]."""
    return angle - TWO_PI * ((angle * (1.0 / TWO_PI) + BIG) - BIG)


@overload
def tanh(x: float) -> float: ...
@overload
def tanh(x: FloatArray) -> FloatArray: ...
def tanh(x: Any) -> Any:
    """Hyperbolic tangent; error below 4e-16."""
    if type(x) is not float and getattr(x, "ndim", None):
        import fleet.ops_lanes as lanes

        return lanes.tanh(x)
    y = minimum(abs(x), 22.0) * -2.0
    k = (y * _LOG2E + BIG) - BIG
    r = (y - k * _LN2_HIGH) - k * _LN2_LOW
    e = _E8 + r * (_E9 + r * (_E10 + r * (_E11 + r * (_E12 + r * _E13))))
    e = _E3 + r * (_E4 + r * (_E5 + r * (_E6 + r * (_E7 + r * e))))
    e = 1.0 + r * (1.0 + r * (0.5 + r * e))
    e = math.ldexp(e, int(k)) if k == k else k  # noqa: PLR0124 - NaN cannot be an exponent
    t = (1.0 - e) / (1.0 + e)
    return -t if x < 0.0 else t


@overload
def select(rules: tuple[tuple[bool, float], ...], default: float) -> float: ...
@overload
def select(rules: tuple[tuple[BoolArray, float], ...], default: FloatArray) -> FloatArray: ...
def select(rules: Any, default: Any) -> Any:
    """The value of the first rule (condition, value) that holds, else the default."""
    result = default
    for cond, value in reversed(rules):
        if some(cond):
            result = where(cond, value, result)
    return result


def when(cond: Bool, law: Callable[[Unpack[Ts]], T], otherwise: T, *args: *Ts) -> T:
    """The lazy `where`: a dear law is worked out only in the lanes that need it.

    For a float an `if`. For a batch the lanes of every argument are gathered, the law is applied to them, and its
    result is scattered into `otherwise`. Arguments and result are values, Structs or tuples of values; whatever is not
    an array (parameters, numbers shared by all lanes) is handed on as it is.
    """
    if cond is True:
        return law(*args)
    if cond is False:
        return otherwise
    import numpy as np

    lanes = np.flatnonzero(cond)
    if lanes.size == 0:
        return otherwise
    if lanes.size == np.size(cond):
        return law(*args)
    gathered: Any = tuple(_gather(a, lanes) for a in args)
    result = law(*gathered)
    merged: T = _scatter(otherwise, result, lanes)
    return merged


def _gather(value: Any, lanes: Any) -> Any:
    """The given lanes of a value."""
    if isinstance(value, msgspec.Struct):
        return type(value)(*(_gather(field, lanes) for field in msgspec.structs.astuple(value)))
    if isinstance(value, tuple):
        return tuple(_gather(v, lanes) for v in value)
    if hasattr(value, "take_lanes"):
        return value.take_lanes(lanes)
    if getattr(value, "ndim", 0) > 0:
        return value.take(lanes, axis=-1)
    return value


def _scatter(base: Any, part: Any, lanes: Any) -> Any:
    """`base` with the given lanes replaced by those of `part`."""
    if isinstance(base, msgspec.Struct):
        fields = zip(msgspec.structs.astuple(base), msgspec.structs.astuple(part), strict=True)
        return type(base)(*(_scatter(b, p, lanes) for b, p in fields))
    if isinstance(base, tuple):
        return tuple(_scatter(b, p, lanes) for b, p in zip(base, part, strict=True))
    if getattr(base, "ndim", 0) > 0:
        result = base.copy()
        result[..., lanes] = part
        return result
    return base
