"""What a scanner's statuses mean. Pure.

Source: Hokuyo, Communication Protocol Specification for SCIP2.0 Standard, C-42-03320B.
"""

from __future__ import annotations

from fleet.drivers.lidar.scip import CHARACTERS

HARDWARE = "hardware trouble: laser or motor"
ANY = {
    "0A": "cannot make a reply",
    "0B": "out of memory, or the command is being worked on",
    "0C": "command too short",
    "0D": "undefined command, or too long",
    "0E": "undefined command",
    "0F": "command not supported, or too short",
    "0G": "more than 16 characters of text",
    "0H": "wrong characters in the text",
    "0I": "firmware is being updated",
    "0L": "scanner is broken",
    "0M": "scanner is unstable",
    "10": "denied: the laser is off, or the state is another",
}
OF_A_MEASUREMENT = {
    "01": "first step is no number",
    "02": "last step is no number",
    "03": "cluster is no number",
    "04": "last step out of range",
    "05": "last step before the first",
    "06": "interval is no number",
    "07": "number of scans is no number",
    "98": "laser works again",
}
OF = {
    "BM": {"01": "laser cannot be switched on", "02": "laser is on already"},
    "TM": {"01": "wrong code", "02": "adjusting already", "03": "not adjusting", "04": "not adjusting"},
}


def in_words(command: str, status: str) -> str:
    """What a status means."""
    if command in CHARACTERS:
        if status in OF_A_MEASUREMENT:
            return OF_A_MEASUREMENT[status]
        if status.isdigit() and 21 <= int(status) <= 49:
            return "stopped to look for an error"
        if status.isdigit() and 50 <= int(status) <= 97:
            return HARDWARE
    return OF.get(command, {}).get(status) or ANY.get(status, f"status {status}")
