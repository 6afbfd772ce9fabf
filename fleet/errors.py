"""The errors that `fleet` raises on purpose.

Every message says what is wrong, the value, where it stands, and what was expected. Trouble at sea is not here: it is
data (`fleet.agent.modes`), because a boat under way must go on deciding.
"""


class FleetError(Exception):
    """Something a person can mend; the command line prints it in one line and ends with `exit_code`."""

    exit_code = 1


class UsageError(FleetError):
    """A wrong input: a file, a flag, a value."""

    exit_code = 2


class FileError(UsageError):
    """A file that cannot be used; carries every problem, not the first."""

    def __init__(self, source: str, problems: tuple[str, ...]) -> None:
        self.source = source
        self.problems = problems
        super().__init__("\n".join(f"{source}: {problem}" for problem in problems))


class MissionError(FileError):
    """A mission file that cannot be sailed."""


class FamilyError(FileError):
    """A family file whose scenarios cannot be drawn."""


class ConfigError(UsageError):
    """A wrong configuration of an agent."""


class NotAllAcknowledged(FleetError):
    """Some boats did not acknowledge a command."""

    exit_code = 3


class NobodyReachable(FleetError):
    """No boat could be reached."""

    exit_code = 4


class RefusedBySafetyCheck(FleetError):
    """A command that the boats, or the check before it, refused for safety."""

    exit_code = 5


class RecordingError(FleetError):
    """A run that cannot be read or written."""
