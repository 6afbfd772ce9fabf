"""What other packages add by name: hulls, ways of keeping clear, drivers; by entry points, loaded when asked for."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

from fleet.errors import UsageError

T = TypeVar("T")


class PluginError(UsageError):
    """Something of an installed package that cannot be used."""


class Kinds(dict[str, T], Generic[T]):
    """Things by name. Those built in are its items; a name that is not is looked for in the entry points of a group.

    So `name in kinds` and `kinds[name]` know what is installed, at the price of a look at all installed packages when a
    name is not built in. Built-in names cannot be taken. Iterating gives those built in, and those loaded so far.
    """

    def __init__(self, group: str, built_in: dict[str, T], needs: tuple[str, ...] = ()) -> None:
        super().__init__(built_in)
        self._group, self._needs = group, needs
        self._why: dict[str, str] = {}

    def __contains__(self, name: object) -> bool:
        if super().__contains__(name):
            return True
        try:
            return isinstance(name, str) and self[name] is not None
        except (KeyError, PluginError):
            return False

    def __missing__(self, name: str) -> T:
        if name in self._why:
            raise PluginError(f"{self._group}: {name}: {self._why[name]}")
        found = self._load(name)
        self[name] = found
        return found

    def why(self, name: str) -> str:
        """Why a name that is installed cannot be used; '' when nothing of that name is installed."""
        return self._why.get(name, "")

    def _load(self, name: str) -> T:
        from importlib.metadata import entry_points

        entries = list(entry_points(group=self._group, name=name))
        if not entries:
            raise KeyError(name)
        package = entries[0].dist.name if entries[0].dist is not None else "a package"
        thing: Any = None
        try:
            thing = entries[0].load()
            missing = [attribute for attribute in self._needs if not hasattr(thing, attribute)]
            wrong = f"has no {', '.join(missing)}" if missing else ""
        except Exception as error:  # noqa: BLE001 - a stranger's code may fail in any way, and must not end an agent
            wrong = f"cannot be loaded: {type(error).__name__}: {error}"
        if wrong:
            self._why[name] = f"{entries[0].value} of {package} {wrong}"
            raise PluginError(f"{self._group}: {name}: {self._why[name]}")
        loaded: T = thing
        return loaded
