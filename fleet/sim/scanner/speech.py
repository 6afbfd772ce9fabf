"""SCIP 2.0 as a scanner speaks it: values to the bytes of its replies. Pure."""

from __future__ import annotations

from msgspec import structs

from fleet.drivers.lidar.scip import BLOCK, CHARACTERS, OK, STREAM, TICKS, Model, Request, checksum, encode


def reply_bytes(echo: bytes, status: str, lines: list[bytes] | None = None, *, words: bool = False) -> bytes:
    """A scanner's reply."""
    told = b"".join(line + (b";" if words else b"") + bytes([checksum(line)]) + b"\n" for line in lines or [])
    state = status.encode()
    return echo + b"\n" + state + bytes([checksum(state)]) + b"\n" + told + b"\n"


def model_lines(model: Model) -> list[bytes]:
    """The lines of a PP reply."""
    values = structs.astuple(model)
    keys = ("MODL", "DMIN", "DMAX", "ARES", "AMIN", "AMAX", "AFRT", "SCAN")
    return [f"{key}:{value}".encode() for key, value in zip(keys, values, strict=True)]


def measurement_bytes(request: Request, ms: int, distances_mm: list[int], left: int = 0) -> bytes:
    """A scanner's measurement; with intensities all alike where the request wants them."""
    characters = CHARACTERS[request.command]
    more = encode(1000, 3) if request.command[1] == "E" else b""
    text = b"".join(encode(value, characters) + more for value in distances_mm)
    lines = [encode(ms % TICKS, 4), *(text[k : k + BLOCK] for k in range(0, len(text), BLOCK))]
    echo = request.steps() + (b"%02d" % left if request.again else b"")
    return reply_bytes(echo, STREAM if request.again else OK, lines)
