"""One station's credentials: its own key and certificate, and whom it believes. Loaded from one folder.

A newer roster, copied into the folder or told over the wire, is taken up while the station runs.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from fleet.errors import ConfigError
from fleet.wire.codec import Refused
from fleet.wire.credentials import files, keys
from fleet.wire.credentials.roster import (
    AUTHORITY,
    PURPOSE,
    Identity,
    Role,
    Roster,
    day,
    read_body,
    read_envelope,
    words_of,
)
from fleet.wire.messages import Signed

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ec import EllipticCurvePrivateKey, EllipticCurvePublicKey
    from cryptography.x509 import Certificate

NEAR_END_DAYS = 30.0
log = logging.getLogger("fleet.wire")


def load(folder: str | Path, fleet: str, role: Role, name: str = "", *, now: Callable[[], float] = time.time) -> Trust:
    """The credentials in a folder; ConfigError names what is missing, wrong, open to others, expired or revoked.

    Args:
        folder: made by `fleet credentials`
        fleet: the fleet that the station is of; '': as the roster says
        role: what the station is
        name: what it is called; '': as its certificate says
        now: seconds of UTC since 1970
    """
    place = files.found(Path(folder))
    authority_at, own_at = str(place / files.AUTHORITY_CERTIFICATE), str(place / files.OWN_CERTIFICATE)
    authority = keys.certificate_of(files.read(place, files.AUTHORITY_CERTIFICATE), authority_at)
    own = keys.certificate_of(files.read(place, files.OWN_CERTIFICATE), own_at)
    key = keys.private_of(files.read(place, files.OWN_KEY), str(place / files.OWN_KEY))
    if not keys.issued_by(own, authority):
        raise ConfigError(f"{own_at}: not issued by the authority in {files.AUTHORITY_CERTIFICATE}; expected its own")
    if own.public_key() != key.public_key():
        raise ConfigError(
            f"{place / files.OWN_KEY}: not the key of {files.OWN_CERTIFICATE}; expected both of one issue"
        )
    _in_time(authority, authority_at, now())
    _in_time(own, own_at, now())
    trust = Trust(place, authority, key, keys.common_name(own), now)
    trust.ends_s = min(own.not_valid_after_utc.timestamp(), authority.not_valid_after_utc.timestamp())
    trust.take_up(files.read(place, files.ROSTER), str(place / files.ROSTER))
    if fleet and trust.roster.fleet != fleet:
        raise ConfigError(f"{place}: credentials of fleet {trust.roster.fleet!r}; expected those of fleet {fleet!r}")
    me = trust.roster.find(trust.common_name)
    if me is None:
        raise ConfigError(
            f"{own_at}: {words_of(trust.common_name)} is not in {files.ROSTER}; expected the newest roster"
        )
    if me.trouble(now()):
        raise ConfigError(f"{own_at}: {me.words} is {me.trouble(now())}; expected a certificate that is valid")
    if me.role != role or (name and me.name != name):
        raise ConfigError(f"{own_at}: of {me.words}; expected one of {role} {name}".rstrip())
    return trust


def _in_time(certificate: Certificate, where: str, now_s: float) -> None:
    begins, ends = certificate.not_valid_before_utc, certificate.not_valid_after_utc
    if now_s > ends.timestamp():
        raise ConfigError(
            f"{where}: expired {day(ends.timestamp())}; expected a valid one: `fleet credentials ... --renew`"
        )
    if now_s < begins.timestamp():
        raise ConfigError(
            f"{where}: valid only from {begins:%Y-%m-%d %H:%M} UTC on, and this machine's clock says {day(now_s)}: "
            "is it right?"
        )


class Trust:
    """Whom a station believes, and its own signature."""

    def __init__(
        self,
        folder: Path,
        authority: Certificate,
        key: EllipticCurvePrivateKey,
        common_name: str,
        now: Callable[[], float],
    ) -> None:
        self.folder, self.common_name, self._key, self._now = folder, common_name, key, now
        self._authority = authority.public_key()
        self.roster = Roster("", 0, 0)
        self.ends_s = 0.0
        self._known: dict[str, tuple[Identity, EllipticCurvePublicKey]] = {}
        self._envelope = b""
        self._seen: tuple[int, int] = (0, 0)
        self._lock = threading.Lock()  # a file and a message may bring a roster at once

    @property
    def name(self) -> str:
        """Of this station."""
        return self.common_name.split(".")[1]

    @property
    def envelope(self) -> bytes:
        """The roster in force as the authority signed it, to be handed on."""
        return self._envelope

    def warning(self) -> str:
        """That the own certificate is about to end, or was revoked; '' when all is well."""
        me = self.roster.find(self.common_name)
        if me is not None and me.revoked_s:
            return f"its certificate was revoked {day(me.revoked_s)}"
        left = (self.ends_s - self._now()) / 86400.0
        if left < 0.0:
            return f"its certificate expired {day(self.ends_s)}"
        return f"its certificate ends in {left:.0f} days" if left < NEAR_END_DAYS else ""

    # -- signatures ------------------------------------------------------------------------------------------------
    def sign(self, purpose: str, body: bytes) -> Signed:
        """Words of this station."""
        content = keys.spoken(purpose, self.roster.fleet, self.common_name, body)
        return Signed(body, keys.sign(self._key, content), self.common_name)

    def members(self, role: Role) -> tuple[Identity, ...]:
        """Of a role, valid now."""
        return self.roster.of(role, self._now())

    def has(self, role: Role, name: str) -> bool:
        """Whether somebody of this role and name is valid now."""
        return any(one.name == name for one in self.members(role))

    def signer(self, purpose: str, words: Signed) -> Identity:
        """Who said these words; Refused, naming them, unless a valid member of the fleet did."""
        if not words.signature:
            raise Refused("is not signed")
        known = self._known.get(words.signer)
        if known is None:
            raise Refused(f"is signed by {words_of(words.signer[:80])}, who is not in the roster")
        identity, key = known
        if identity.trouble(self._now()):
            raise Refused(f"is signed by {identity.words}, {identity.trouble(self._now())}")
        if not keys.verifies(key, words.signature, keys.spoken(purpose, self.roster.fleet, words.signer, words.body)):
            raise Refused(f"does not bear the signature of {identity.words}: forged or altered")
        return identity

    # -- the roster ------------------------------------------------------------------------------------------------
    def take_up(self, content: bytes, where: str) -> bool:
        """Believe a roster if it is the authority's and newer; False when it is not newer, ConfigError otherwise."""
        signed = read_envelope(content, where)
        from cryptography.hazmat.primitives.asymmetric import ec

        assert isinstance(self._authority, ec.EllipticCurvePublicKey)
        roster = read_body(signed, where)  # its fleet is part of what is signed
        if not keys.verifies(
            self._authority, signed.signature, keys.spoken(PURPOSE, roster.fleet, AUTHORITY, signed.body)
        ):
            raise ConfigError(
                f"{where}: not signed by the authority in {files.AUTHORITY_CERTIFICATE}; expected its roster"
            )
        known = {one.common_name: (one, keys.public_of(one.key, f"{where}: {one.words}")) for one in roster.members}
        with self._lock:
            if self.roster.fleet and roster.fleet != self.roster.fleet:
                raise ConfigError(f"{where}: of fleet {roster.fleet!r}; expected {self.roster.fleet!r}")
            if roster.number <= self.roster.number:
                return False
            self.roster, self._known, self._envelope = roster, known, content
        return True

    def told(self, content: bytes, by: str) -> bool:
        """A roster that came over the wire; kept on disk when it is newer. Refused when it is not the authority's."""
        try:
            newer = self.take_up(content, "the roster")
        except ConfigError as error:
            raise Refused(str(error)) from None
        if newer:
            log.warning("roster %d in force, from %s", self.roster.number, by, extra={"event": "roster"})
            try:
                files.write(self.folder, files.ROSTER, content)
            except ConfigError as error:
                log.warning("the roster is in force, but not kept: %s", error, extra={"event": "roster"})
        return newer

    def look(self) -> bool:
        """Take up a newer roster from the folder, if there is one."""
        path = self.folder / files.ROSTER
        try:
            at = path.stat()
            seen = (at.st_mtime_ns, at.st_size)
            if seen == self._seen:
                return False
            self._seen = seen
            newer = self.take_up(path.read_bytes(), str(path))
        except (OSError, ConfigError) as error:
            log.warning("roster not taken up: %s", error, extra={"event": "roster"})
            return False
        if newer:
            log.warning("roster %d in force, from %s", self.roster.number, path, extra={"event": "roster"})
        return newer
