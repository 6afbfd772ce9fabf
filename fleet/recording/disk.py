"""The seam to the file system: streams that write all or say why not, names of parts, free space, words for errors."""

from __future__ import annotations

import errno
import io
import os
from pathlib import Path

_WORDS = {
    errno.ENOSPC: "disk full",
    errno.EDQUOT: "disk quota used up",
    errno.EFBIG: "largest file size reached",
    errno.EROFS: "disk is read-only",
    errno.EACCES: "not allowed to write",
    errno.EPERM: "not allowed to write",
    errno.EIO: "disk does not answer",
    errno.ENOENT: "no such folder",
    errno.ENODEV: "disk is gone",
}


class DiskStream(io.BufferedIOBase):
    """A new file that is only appended to. Nothing is held back: what was written before a failure is in the file.

    A buffered file would try the failed bytes again when it is closed; a raw one may write half and not say so.
    """

    def __init__(self, path: Path, flags: int = os.O_CREAT | os.O_EXCL) -> None:
        self._fd = os.open(path, os.O_WRONLY | os.O_CLOEXEC | flags, 0o644)
        self._at = 0

    def writable(self) -> bool:
        """It is."""
        return True

    def write(self, content: bytes | bytearray | memoryview, /) -> int:  # type: ignore[override]
        """Write all of it, or raise OSError."""
        rest = memoryview(content)
        while rest:
            written = os.write(self._fd, rest)
            self._at += written
            rest = rest[written:]
        return len(content)

    def tell(self) -> int:
        """Bytes written so far."""
        return self._at

    def fileno(self) -> int:
        """Descriptor, for fsync."""
        return self._fd

    def close(self) -> None:
        """Close the file; a second time does nothing."""
        if not self.closed:
            super().close()
            os.close(self._fd)


def open_new(path: Path) -> DiskStream:
    """A new file, and the folders it lies in; an existing one is never overwritten."""
    path.parent.mkdir(parents=True, exist_ok=True)
    stream = DiskStream(path)
    sync_folder(path.parent)
    return stream


def sync_folder(folder: Path) -> None:
    """Make a new name in a folder survive a power cut, where the file system can."""
    try:
        fd = os.open(folder, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(fd)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EBADF, errno.EROFS):
            raise
    finally:
        os.close(fd)


def part(path: Path, number: int) -> Path:
    """Name of part 1, 2, ... of a recording: `run.mcap`, `run.2.mcap`, ..."""
    return path if number == 1 else path.with_name(f"{path.stem}.{number}{path.suffix}")


def parts(path: Path) -> list[Path]:
    """The parts of a recording that exist, in order."""
    found = []
    for candidate in path.parent.glob(f"{path.stem}.*{path.suffix}"):
        middle = candidate.name[len(path.stem) + 1 : -len(path.suffix)]
        if middle.isascii() and middle.isdigit() and int(middle) > 1:
            found.append(int(middle))
    first = [path] if path.exists() else []
    return first + [part(path, number) for number in sorted(found)]


def free_bytes(path: Path | str) -> int:
    """Bytes that an ordinary user can still write where `path` is or will be."""
    place = Path(path).absolute()
    while not place.exists() and place != place.parent:
        place = place.parent
    figures = os.statvfs(place)
    return figures.f_bavail * figures.f_frsize


def in_words(error: OSError) -> str:
    """What went wrong, for a person: `disk full: runs/a/run.mcap: No space left on device`."""
    word = _WORDS.get(error.errno or 0, "cannot write")
    where = f"{error.filename}: " if error.filename else ""
    return f"{word}: {where}{error.strerror or error}"
