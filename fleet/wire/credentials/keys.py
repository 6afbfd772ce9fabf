"""Keys, signatures, certificates: with `authority.py` the only file that imports `cryptography`, and only when needed.

ECDSA on P-256 with SHA-256. What is signed begins with what it is for, the fleet and the signer, so that no word can be
taken for another kind of word, nor for another fleet's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fleet.errors import ConfigError

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ec import EllipticCurvePrivateKey, EllipticCurvePublicKey
    from cryptography.x509 import Certificate

_FIRST = b"fleet words 1"


def spoken(purpose: str, fleet: str, signer: str, body: bytes) -> bytes:
    """The bytes that are signed."""
    return b"\0".join((_FIRST, purpose.encode(), fleet.encode(), signer.encode(), body))


def sign(key: EllipticCurvePrivateKey, content: bytes) -> bytes:
    """A signature over the content."""
    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import ec

    return key.sign(content, ec.ECDSA(hashes.SHA256()))


def verifies(key: EllipticCurvePublicKey, signature: bytes, content: bytes) -> bool:
    """Whether the holder of the key signed the content."""
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import ec

    try:
        key.verify(signature, content, ec.ECDSA(hashes.SHA256()))
    except InvalidSignature:
        return False
    return True


def new_key() -> EllipticCurvePrivateKey:
    """A new private key."""
    from cryptography.hazmat.primitives.asymmetric import ec

    return ec.generate_private_key(ec.SECP256R1())


def public_of(der: bytes, where: str) -> EllipticCurvePublicKey:
    """A public key in DER; ConfigError when it is none of ours."""
    from cryptography.exceptions import UnsupportedAlgorithm
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.serialization import load_der_public_key

    try:
        key = load_der_public_key(der)
    except (ValueError, UnsupportedAlgorithm):
        raise ConfigError(f"{where}: not a public key; expected EC P-256") from None
    if not isinstance(key, ec.EllipticCurvePublicKey) or key.curve.name != "secp256r1":
        raise ConfigError(f"{where}: another kind of key; expected EC P-256")
    return key


def public_bytes(key: EllipticCurvePublicKey) -> bytes:
    """A public key in DER."""
    from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

    return key.public_bytes(Encoding.DER, PublicFormat.SubjectPublicKeyInfo)


def private_bytes(key: EllipticCurvePrivateKey) -> bytes:
    """A private key in PEM, not encrypted: a boat must start by itself."""
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())


def private_of(content: bytes, where: str) -> EllipticCurvePrivateKey:
    """A private key in PEM; ConfigError when it is none of ours."""
    from cryptography.exceptions import UnsupportedAlgorithm
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    try:
        key = load_pem_private_key(content, None)
    except (ValueError, TypeError, UnsupportedAlgorithm):
        raise ConfigError(f"{where}: not a private key; expected EC P-256 in PEM, without a passphrase") from None
    if not isinstance(key, ec.EllipticCurvePrivateKey) or key.curve.name != "secp256r1":
        raise ConfigError(f"{where}: another kind of key; expected EC P-256")
    return key


def certificate_of(content: bytes, where: str) -> Certificate:
    """A certificate in PEM; ConfigError when it is none."""
    from cryptography.x509 import load_pem_x509_certificate

    try:
        return load_pem_x509_certificate(content)
    except ValueError:
        raise ConfigError(f"{where}: not a certificate; expected X.509 in PEM") from None


def issued_by(certificate: Certificate, authority: Certificate) -> bool:
    """Whether the authority signed the certificate."""
    from cryptography.exceptions import InvalidSignature

    try:
        certificate.verify_directly_issued_by(authority)
    except (ValueError, TypeError, InvalidSignature):
        return False
    return True


def common_name(certificate: Certificate) -> str:
    """What a certificate calls its holder; '' for none."""
    from cryptography.x509.oid import NameOID

    names = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    return str(names[0].value) if names else ""
