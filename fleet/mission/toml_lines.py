"""On which line of a TOML file each key stands; the standard library's parser does not say."""

from __future__ import annotations

import re

from fleet.mission.problem import Key

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_SPACE = re.compile(r"[ \t]*")
_GAP = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_SCALAR = re.compile(r"[^,\]}#\r\n]*")
_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"""+|'  # the + takes quotes that stand just before the closing ones
    r"'''.*?'''+|"
    r'"(?:\\.|[^"\\])*"|'
    r"'[^']*'",
    re.DOTALL,
)


def key_lines(text: str) -> dict[Key, int]:
    """Line (from 1) of every key, table and list entry of a text that `tomllib` accepts."""
    return _Finder(text).run()


class _Finder:
    """A walk over a text that is known to be right: it looks for keys and skips values."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.lines: dict[Key, int] = {}
        self.entries: dict[Key, int] = {}  # how many [[...]] each list of tables has so far

    def run(self) -> dict[Key, int]:
        """Walk from the first line to the last."""
        table: Key = ()
        self.skip(_GAP)
        while self.at < len(self.text):
            if self.text.startswith("[", self.at):
                table = self.header()
            else:
                self.pair(table)
            self.skip(_GAP)
        return self.lines

    def header(self) -> Key:
        """`[table]` or `[[list of tables]]`; its full key with the places in lists."""
        brackets = 2 if self.text.startswith("[[", self.at) else 1
        self.at += brackets
        names = self.key()
        key = self.resolve(names[:-1])
        key = (*key, names[-1])
        if brackets == 2:
            self.note(key)
            self.entries[key] = self.entries.get(key, -1) + 1
            key = (*key, self.entries[key])
        else:
            key = self.resolve(names)
        self.note(key)
        self.at += brackets
        return key

    def resolve(self, names: Key) -> Key:
        """The key with the newest place put in after each list of tables."""
        key: Key = ()
        for name in names:
            key = (*key, name)
            if key in self.entries:
                key = (*key, self.entries[key])
        return key

    def pair(self, table: Key) -> None:
        """`key = value`."""
        key = table
        for name in self.key():
            key = (*key, name)
            self.note(key)
        self.at += 1  # =
        self.skip(_SPACE)
        self.value(key)

    def key(self) -> tuple[str, ...]:
        """`a.b."c d"`, up to what follows it."""
        names = []
        while True:
            self.skip(_SPACE)
            found = _STRING.match(self.text, self.at)
            if found:
                names.append(found.group()[1:-1])
            else:
                found = _BARE.match(self.text, self.at)
                names.append(found.group() if found else "")
            self.at = found.end() if found else self.at + 1
            self.skip(_SPACE)
            if not self.text.startswith(".", self.at):
                return tuple(names)
            self.at += 1

    def value(self, key: Key) -> None:
        """Past a value, noting the keys and entries in it."""
        if self.text.startswith("[", self.at):
            self.at += 1
            self.several(key, "]")
        elif self.text.startswith("{", self.at):
            self.at += 1
            self.several(key, "}")
        else:
            self.skip(_STRING if self.text.startswith(('"', "'"), self.at) else _SCALAR)

    def several(self, key: Key, closing: str) -> None:
        """The entries of a list, or the pairs of an inline table."""
        i = 0
        self.skip(_GAP)
        while self.at < len(self.text) and not self.text.startswith(closing, self.at):
            if closing == "}":
                self.pair(key)
            else:
                self.note((*key, i))
                self.value((*key, i))
                i += 1
            self.skip(_GAP)
            if self.text.startswith(",", self.at):
                self.at += 1
                self.skip(_GAP)
        self.at += 1

    def note(self, key: Key) -> None:
        """Remember the first line on which a key appears."""
        self.lines.setdefault(key, self.text.count("\n", 0, self.at) + 1)

    def skip(self, pattern: re.Pattern[str]) -> None:
        """Past what the pattern matches here."""
        found = pattern.match(self.text, self.at)
        if found:
            self.at = found.end()
