"""Does a tree of values have the shape of a mission? Every value that does not fit, not the first one."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, TypeVar

import msgspec
from msgspec import inspect as shape

from fleet.errors import MissionError
from fleet.mission.problem import Key, Problem, hint

T = TypeVar("T")

PLACE = "expected [north_m, east_m] from the datum or { lat_deg = , lon_deg = }"
KINDS = {  # how a person calls what TOML calls a type
    shape.StrType: "text",
    shape.BoolType: "true or false",
    shape.IntType: "a whole number",
    shape.DictType: "a table",
    shape.StructType: "a table",
    shape.VarTupleType: "a list",
    shape.TupleType: "a list",
}
DEEPEST = 12  # levels of nesting; a mission has six


def problems(value: Any, kind: type, where: Key = ()) -> tuple[Problem, ...]:
    """Everything in `value` that does not fit `kind`, a msgspec type."""
    return tuple(_walk(value, _shape_of(kind), where))


@lru_cache
def _shape_of(kind: Any) -> shape.Type:
    """What msgspec knows of a type; asked once."""
    return shape.type_info(kind)


def convert(value: Any, kind: type[T], source: str) -> T:
    """`value` as a `kind`; MissionError with every misfit."""
    found = problems(value, kind)
    if found:
        raise MissionError(source, tuple(problem.text() for problem in found))
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:  # something that the walk above does not know
        raise MissionError(source, (str(error),)) from None


def _walk(value: Any, kind: shape.Type, where: Key) -> Iterator[Problem]:
    """The misfits of one value and of everything in it."""
    if len(where) > DEEPEST:
        yield Problem(where, "nested too deep")
    elif isinstance(kind, shape.UnionType):
        yield from _union(value, kind, where)
    elif isinstance(kind, shape.StructType):
        yield from _struct(value, kind, where)
    elif isinstance(kind, shape.DictType):
        yield from _table(value, kind, where)
    elif isinstance(kind, shape.VarTupleType | shape.TupleType):
        yield from _list(value, kind, where)
    else:
        wrong = _leaf(value, kind)
        if wrong:
            yield Problem(where, wrong, value)


def _union(value: Any, kind: shape.UnionType, where: Key) -> Iterator[Problem]:
    """None or something, a place, or one of several tables told apart by their `kind`."""
    options = [option for option in kind.types if not isinstance(option, shape.NoneType)]
    if value is None and len(options) < len(kind.types):
        return
    tables = [option for option in options if isinstance(option, shape.StructType)]
    numbers = [option for option in options if isinstance(option, shape.FloatType)]
    words = [option for option in options if isinstance(option, shape.StrType)]
    if len(options) == 1:
        yield from _walk(value, options[0], where)
    elif words and isinstance(value, str):
        yield from _walk(value, words[0], where)
    elif tables and tables[0].tag_field is not None:
        yield from _tagged(value, tables, tables[0].tag_field, where)
    elif isinstance(value, dict) and tables:
        yield from _walk(value, tables[0], where)
    elif numbers:
        yield from _walk(value, numbers[0], where)
    elif isinstance(value, list | tuple) and len(value) == 2:
        yield from (p for option in options if option not in tables for p in _walk(value, option, where))
    else:
        yield Problem(where, PLACE, value)


def _tagged(value: Any, tables: list[shape.StructType], tag: str, where: Key) -> Iterator[Problem]:
    """One of several tables, told apart by the key `tag`."""
    names = [str(table.tag) for table in tables]
    wanted = f"expected one of {', '.join(names)}"
    if not isinstance(value, dict):
        yield Problem(where, f"expected a table with {tag} = one of {', '.join(names)}", value)
    elif tag not in value:
        yield Problem((*where, tag), f"missing, {wanted}")
    elif value[tag] not in names:
        near = hint(str(value[tag]), names)
        yield Problem((*where, tag), wanted + (near if "did you" in near else ""), value[tag])
    else:
        yield from _struct(value, tables[names.index(value[tag])], where)


def _struct(value: Any, kind: shape.StructType, where: Key) -> Iterator[Problem]:
    """A table with known keys."""
    if not isinstance(value, dict):
        yield Problem(where, _expected(kind), value)
        return
    fields = {field.encode_name: field for field in kind.fields}
    misspelt = ""
    for key, item in value.items():
        if key in fields:
            yield from _walk(item, fields[key].type, (*where, key))
        elif key != kind.tag_field:
            near = hint(str(key), [name for name in fields if name not in value] or fields)
            misspelt += near if "did you" in near else ""
            yield Problem((*where, str(key)), "unknown key" + near)
    for key, field in fields.items():
        if field.required and key not in value and f'"{key}"' not in misspelt:
            yield Problem((*where, key), f"missing, {_expected(field.type)}")


def _table(value: Any, kind: shape.DictType, where: Key) -> Iterator[Problem]:
    """A table whose keys are names that the writer chose."""
    if not isinstance(value, dict):
        yield Problem(where, _expected(kind), value)
        return
    for key, item in value.items():
        if isinstance(key, str):
            yield from _walk(item, kind.value_type, (*where, key))
        else:
            yield Problem(where, "expected keys that are text", key)


def _list(value: Any, kind: shape.VarTupleType | shape.TupleType, where: Key) -> Iterator[Problem]:
    """A list of any length, or of a given one."""
    if not isinstance(value, list | tuple):
        yield Problem(where, _expected(kind), value)
        return
    if isinstance(kind, shape.TupleType):
        for i, (item, item_kind) in enumerate(zip(value, kind.item_types, strict=False)):
            yield from _walk(item, item_kind, (*where, i))
        return
    if len(value) < (kind.min_length or 0):
        yield Problem(where, f"expected at least {kind.min_length} entries, got {len(value)}")
    for i, item in enumerate(value):
        yield from _walk(item, kind.item_type, (*where, i))


def _leaf(value: Any, kind: shape.Type) -> str | None:
    """What is wrong with a single value, or None."""
    fits = False
    if isinstance(kind, shape.FloatType):
        fits = isinstance(value, int | float) and not isinstance(value, bool) and _within(value, kind)
    elif isinstance(kind, shape.IntType):
        fits = isinstance(value, int) and not isinstance(value, bool) and _within(value, kind)
    elif isinstance(kind, shape.StrType):
        fits = isinstance(value, str) and _length_fits(value, kind) and bool(re.search(kind.pattern or "", value))
    elif isinstance(kind, shape.BoolType):
        fits = isinstance(value, bool)
    elif isinstance(kind, shape.LiteralType):
        fits = isinstance(value, str) and value in kind.values
    return None if fits else _expected(kind)


def _length_fits(value: str, kind: shape.StrType) -> bool:
    """Whether a text is neither too short nor too long."""
    return (kind.min_length or 0) <= len(value) <= (kind.max_length or math.inf)


def _within(value: float, kind: shape.FloatType | shape.IntType) -> bool:
    """Whether a number is finite and within its bounds."""
    return (
        abs(value) <= 1e300  # whole numbers of TOML have no end
        and (kind.gt is None or value > kind.gt)
        and (kind.ge is None or value >= kind.ge)
        and (kind.lt is None or value < kind.lt)
        and (kind.le is None or value <= kind.le)
    )


def _expected(kind: shape.Type) -> str:
    """What stands here in a right mission."""
    if isinstance(kind, shape.UnionType):
        options = [option for option in kind.types if not isinstance(option, shape.NoneType)]
        numbers = [option for option in options if isinstance(option, shape.FloatType)]
        return _expected(numbers[0] if numbers else options[0]) if numbers or len(options) == 1 else PLACE
    if isinstance(kind, shape.FloatType):
        return f"expected a number{_bounds(kind)}"
    if isinstance(kind, shape.IntType):
        return f"expected a whole number{_bounds(kind)}"
    if isinstance(kind, shape.LiteralType):
        return f"expected one of {', '.join(str(v) for v in kind.values)}"
    if isinstance(kind, shape.StrType) and kind.pattern is not None:
        return "expected a name of 1 to 32 characters a-z, 0-9 or -"
    if isinstance(kind, shape.StrType) and kind.max_length is not None:
        return f"expected text of {kind.min_length} to {kind.max_length} characters"
    return f"expected {KINDS.get(type(kind), 'something else')}"


def _bounds(kind: shape.FloatType | shape.IntType) -> str:
    """` above 0`, ` from 1 to 50`."""
    if kind.ge is not None and kind.le is not None:
        return f" from {kind.ge:.12g} to {kind.le:.12g}"
    if kind.gt is not None:
        return f" above {kind.gt:g}"
    return f" of at least {kind.ge:g}" if kind.ge is not None else ""
