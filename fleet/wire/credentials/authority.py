"""The fleet's own authority: it gives certificates, revokes them, and signs the roster. One folder, kept on shore."""

from __future__ import annotations

import ipaddress
import re
import secrets
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from msgspec import structs

from fleet.errors import UsageError
from fleet.wire.credentials import files, keys
from fleet.wire.credentials.roster import AUTHORITY, PURPOSE, Identity, Role, Roster, read_body, read_envelope
from fleet.wire.keys import valid_name
from fleet.wire.messages import Signed

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ec import EllipticCurvePrivateKey
    from cryptography.x509 import Certificate, CertificateBuilder, GeneralName, Name

ALWAYS_HOSTS = ("localhost", "127.0.0.1", "::1")
AUTHORITY_DAYS = 3650
BEFORE = timedelta(hours=1)  # clocks of boats may be behind
FORGET_S = 90 * 86400  # so long after its end an identity leaves the roster
MOST_DAYS = 3650
_HOST = re.compile(r"[A-Za-z0-9]([A-Za-z0-9.-]{0,251}[A-Za-z0-9])?")


def create(folder: Path, fleet: str, now_s: float) -> Authority:
    """Found an authority in a folder; UsageError where there is one."""
    valid_name("fleet", fleet)
    for name in (files.AUTHORITY_KEY, files.AUTHORITY_CERTIFICATE, files.ROSTER):
        if (folder / name).exists():
            raise UsageError(f"{folder / name}: exists: expected a folder without an authority; it is not overwritten")
    key = keys.new_key()
    name_of = _name(f"authority of fleet {fleet}")
    certificate = _signed(_certificate(name_of, name_of, key, now_s, AUTHORITY_DAYS), key, ca=True)
    files.make(folder)
    files.write(folder, files.AUTHORITY_CERTIFICATE, _pem(certificate))
    files.write(folder, files.AUTHORITY_KEY, keys.private_bytes(key))
    authority = Authority(folder, key, certificate, Roster(fleet, 0, int(now_s)))
    authority._publish(authority.roster.members, now_s)
    return authority


def load(folder: Path) -> Authority:
    """The authority in a folder; ConfigError where there is none, or its key is open to others."""
    files.found(folder)
    certificate_at = str(folder / files.AUTHORITY_CERTIFICATE)
    certificate = keys.certificate_of(files.read(folder, files.AUTHORITY_CERTIFICATE), certificate_at)
    key = keys.private_of(files.read(folder, files.AUTHORITY_KEY), str(folder / files.AUTHORITY_KEY))
    where = str(folder / files.ROSTER)
    signed = read_envelope(files.read(folder, files.ROSTER), where)
    roster = read_body(signed, where)
    content = keys.spoken(PURPOSE, roster.fleet, AUTHORITY, signed.body)
    if keys.public_bytes(key.public_key()) != keys.public_bytes(certificate.public_key()):  # type: ignore[arg-type]
        raise UsageError(f"{certificate_at} and {files.AUTHORITY_KEY} do not belong together")
    if not keys.verifies(key.public_key(), signed.signature, content):
        raise UsageError(f"{where}: not signed by this authority; expected its own roster")
    return Authority(folder, key, certificate, roster)


class Authority:
    """Who may belong to the fleet."""

    def __init__(self, folder: Path, key: EllipticCurvePrivateKey, certificate: Certificate, roster: Roster) -> None:
        self.folder, self._key, self.certificate, self.roster = folder, key, certificate, roster

    def issue(
        self,
        role: Role,
        name: str,
        now_s: float,
        *,
        days: float = 365.0,
        hosts: Sequence[str] = (),
        renew: bool = False,
    ) -> Path:
        """A certificate and a key for a station; the folder to be copied to it.

        Args:
            role: boat, operator or hub
            name: of the station
            now_s: seconds of UTC since 1970
            days: how long it is valid
            hosts: names and addresses under which others connect to it
            renew: a new one beside one that is still valid; the old one stays valid until its end
        """
        valid_name(role, name)
        if not 0.0 < days <= MOST_DAYS:
            raise UsageError(f"--days {days:g}: expected more than 0 and at most {MOST_DAYS}")
        for other in self.roster.members:
            if other.name != name or other.trouble(now_s):
                continue
            if other.role != role:
                raise UsageError(f"{role} {name}: there is a valid {other.words}; expected a name of its own")
            if not renew:
                raise UsageError(
                    f"{role} {name}: has a certificate until {_date(other.ends_s)}; expected another name, --renew, or "
                    f"`fleet credentials revoke {name}` first"
                )
        alternatives = [_general_name(host) for host in dict.fromkeys((*ALWAYS_HOSTS, *hosts))]
        key, serial = keys.new_key(), secrets.token_hex(8)
        common_name = f"{role}.{name}.{serial}"
        builder = _certificate(_name(common_name), self.certificate.subject, key, now_s, days)
        certificate = _signed(builder, self._key, ca=False, hosts=alternatives)
        identity = Identity(
            role,
            name,
            serial,
            keys.public_bytes(key.public_key()),
            int(certificate.not_valid_before_utc.timestamp()),
            int(certificate.not_valid_after_utc.timestamp()),
            _fingerprint(certificate),
        )
        folder = self.folder / name
        files.make(folder)
        files.write(folder, files.AUTHORITY_CERTIFICATE, _pem(self.certificate))
        files.write(folder, files.OWN_KEY, keys.private_bytes(key))
        files.write(folder, files.OWN_CERTIFICATE, _pem(certificate))
        self._publish((*self.roster.members, identity), now_s)
        return folder

    def revoke(self, name: str, now_s: float) -> tuple[Identity, ...]:
        """Nobody believes this name's certificates any more, as soon as the new roster has come to them."""
        gone = tuple(one for one in self.roster.members if one.name == name and not one.revoked_s)
        if not gone:
            known = ", ".join(sorted({one.name for one in self.roster.members if not one.revoked_s})) or "nobody"
            raise UsageError(f"revoke {name}: has no certificate to revoke; expected one of {known}")
        members = tuple(
            structs.replace(one, revoked_s=int(now_s)) if one in gone else one for one in self.roster.members
        )
        self._publish(members, now_s)
        return gone

    def _publish(self, members: tuple[Identity, ...], now_s: float) -> None:
        """Sign the next roster; it goes into the authority's folder and into every station's below it."""
        kept = tuple(one for one in members if one.revoked_s or now_s < one.ends_s + FORGET_S)
        self.roster = Roster(self.roster.fleet, self.roster.number + 1, int(now_s), kept)
        body = msgspec.json.encode(self.roster)
        content = keys.spoken(PURPOSE, self.roster.fleet, AUTHORITY, body)
        envelope = msgspec.json.encode(Signed(body, keys.sign(self._key, content), AUTHORITY))
        for folder in sorted({self.folder / one.name for one in kept}):
            if (folder / files.OWN_CERTIFICATE).exists():
                files.write(folder, files.ROSTER, envelope)
        files.write(self.folder, files.ROSTER, envelope)


def _name(common_name: str) -> Name:
    from cryptography import x509
    from cryptography.x509.oid import NameOID

    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])


def _general_name(host: str) -> GeneralName:
    from cryptography import x509

    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        if not _HOST.fullmatch(host):
            raise UsageError(f"--hosts {host!r}: expected names or addresses, without ports") from None
        return x509.DNSName(host)


def _certificate(
    subject: Name, issuer: Name, key: EllipticCurvePrivateKey, now_s: float, days: float
) -> CertificateBuilder:
    from cryptography import x509

    now = datetime.fromtimestamp(now_s, UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - BEFORE)
        .not_valid_after(now + timedelta(days=days))
    )


def _signed(
    builder: CertificateBuilder, key: EllipticCurvePrivateKey, *, ca: bool, hosts: Sequence[GeneralName] = ()
) -> Certificate:
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes
    from cryptography.x509.oid import ExtendedKeyUsageOID

    builder = builder.add_extension(x509.BasicConstraints(ca=ca, path_length=0 if ca else None), critical=True)
    usage = x509.KeyUsage(
        digital_signature=True,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=ca,
        crl_sign=ca,
        encipher_only=False,
        decipher_only=False,
    )
    builder = builder.add_extension(usage, critical=True)
    if not ca:
        builder = builder.add_extension(x509.SubjectAlternativeName(list(hosts)), critical=False)
        both = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
        builder = builder.add_extension(x509.ExtendedKeyUsage(both), critical=False)
    return builder.sign(key, hashes.SHA256())


def _pem(certificate: Certificate) -> bytes:
    from cryptography.hazmat.primitives.serialization import Encoding

    return certificate.public_bytes(Encoding.PEM)


def _fingerprint(certificate: Certificate) -> str:
    from cryptography.hazmat.primitives import hashes

    return certificate.fingerprint(hashes.SHA256()).hex()


def _date(seconds: int) -> str:
    return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%d")
