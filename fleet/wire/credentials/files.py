"""Files of credentials: keys that only their owner may read, folders that only their owner may write."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from fleet.errors import ConfigError

AUTHORITY_KEY, AUTHORITY_CERTIFICATE = "authority.key", "authority.pem"
OWN_KEY, OWN_CERTIFICATE = "own.key", "own.pem"
ROSTER = "roster.json"
_WHAT = {
    AUTHORITY_KEY: "the authority's private key, made by `fleet credentials init`",
    AUTHORITY_CERTIFICATE: "the authority's certificate, made by `fleet credentials init`",
    OWN_KEY: "this station's private key, made by `fleet credentials boat|operator|hub NAME`",
    OWN_CERTIFICATE: "this station's certificate, made by `fleet credentials boat|operator|hub NAME`",
    ROSTER: "the signed roster, written by `fleet credentials`",
}


def read(folder: Path, name: str) -> bytes:
    """A file of credentials; ConfigError when it is missing, or open to others and a key."""
    path = folder / name
    try:
        if name.endswith(".key"):
            mode = stat.S_IMODE(path.stat().st_mode)
            if mode & 0o077:
                raise ConfigError(
                    f"{path}: its mode is {mode:04o}, so that others may read or change it: expected 0600 (chmod 600 "
                    f"{path}); if others may have read it, revoke it"
                )
        return path.read_bytes()
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such file; expected {_WHAT[name]}") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}; expected {_WHAT[name]}") from None


def found(folder: Path) -> Path:
    """The folder, if it is one that only its owner may write; ConfigError otherwise."""
    try:
        mode = stat.S_IMODE(folder.stat().st_mode)
    except FileNotFoundError:
        raise ConfigError(f"{folder}: no such folder; expected one made by `fleet credentials`") from None
    except OSError as error:
        raise ConfigError(f"{folder}: {error.strerror}; expected a folder made by `fleet credentials`") from None
    if not folder.is_dir():
        raise ConfigError(f"{folder}: not a folder; expected one made by `fleet credentials`")
    if mode & 0o022:
        raise ConfigError(f"{folder}: its mode is {mode:04o}, so that others may change it: expected 0700")
    return folder


def make(folder: Path) -> None:
    """A folder that only its owner may look into; ConfigError when it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        folder.chmod(0o700)
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be made: {error.strerror}") from None


def write(folder: Path, name: str, content: bytes) -> None:
    """A file replaced whole, or not at all; a key is nobody else's to read from its first byte on."""
    path, new = folder / name, folder / f".{name}.new"
    try:
        new.unlink(missing_ok=True)
        handle = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600 if name.endswith(".key") else 0o644)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        new.replace(path)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {error.strerror}") from None
