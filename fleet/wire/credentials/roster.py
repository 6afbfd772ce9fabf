"""The roster: who belongs to the fleet, with key, role and end of validity; revoked ones too. Signed by the authority.

An identity is one certificate, not one name: its serial number stands in the certificate's common name, so that a name
that is issued anew is somebody else, and what was revoked stays revoked.
"""

from __future__ import annotations

from typing import Literal

import msgspec
from msgspec import Struct

from fleet.errors import ConfigError
from fleet.wire.messages import Signed

Role = Literal["boat", "operator", "hub"]
ROLES: tuple[Role, ...] = ("boat", "operator", "hub")
AUTHORITY = "authority"
"""The signer of rosters."""
PURPOSE = "roster"
LARGEST = 1 << 20  # bytes of a roster; a thousand members are a quarter of it


class Identity(Struct, frozen=True):
    """One certificate."""

    role: Role
    name: str
    serial: str  # 16 hexadecimal digits, of this certificate alone
    key: bytes  # public, DER
    begins_s: int  # seconds of UTC since 1970
    ends_s: int
    fingerprint: str  # SHA-256 of the certificate, hexadecimal
    revoked_s: int = 0  # when; 0: not

    @property
    def common_name(self) -> str:
        """`boat.b2.0123456789abcdef`: what the certificate calls its holder."""
        return f"{self.role}.{self.name}.{self.serial}"

    @property
    def words(self) -> str:
        """`boat b2 (0123456789abcdef)`."""
        return f"{self.role} {self.name} ({self.serial})"

    def trouble(self, now_s: float) -> str:
        """Why it is not valid now; '' when it is."""
        if self.revoked_s:
            return "revoked"
        if now_s > self.ends_s:
            return f"expired {day(self.ends_s)}"
        return ""


class Roster(Struct, frozen=True):
    """Everybody whom the authority ever gave a certificate that has not expired long since."""

    fleet: str
    number: int  # one more with every change; the larger one is in force
    stamp_s: int
    members: tuple[Identity, ...] = ()

    def of(self, role: Role, now_s: float) -> tuple[Identity, ...]:
        """The members of a role that are valid now."""
        return tuple(one for one in self.members if one.role == role and not one.trouble(now_s))

    def find(self, common_name: str) -> Identity | None:
        """Who is called so."""
        return next((one for one in self.members if one.common_name == common_name), None)


def day(seconds: float) -> str:
    """A date in UTC."""
    from datetime import UTC, datetime

    return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%d")


def words_of(common_name: str) -> str:
    """`boat b2 (0123456789abcdef)` of a common name; the name itself when it is none of ours."""
    parts = common_name.split(".")
    return f"{parts[0]} {parts[1]} ({parts[2]})" if len(parts) == 3 and parts[0] in ROLES else repr(common_name)


def read_envelope(content: bytes, where: str) -> Signed:
    """A roster as it stands in a file or a message, its signature not yet looked at; ConfigError when it is none."""
    try:
        if len(content) > LARGEST:
            raise msgspec.DecodeError("too large")
        return msgspec.json.decode(content, type=Signed)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ConfigError(f"{where}: not a roster: {error}; expected what `fleet credentials` writes") from None


def read_body(signed: Signed, where: str) -> Roster:
    """The roster in an envelope whose signature was found good; ConfigError when it is none."""
    try:
        return msgspec.json.decode(signed.body, type=Roster)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ConfigError(f"{where}: not a roster: {error}; expected what `fleet credentials` writes") from None
