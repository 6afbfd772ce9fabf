"""A bridge with a fleet made by hand and ground stations that speak real frames; time is a number."""

from __future__ import annotations

from typing import Any

from msgspec import structs

from fleet.agent.modes import Mode
from fleet.drivers.mavlink.words import ARDUPILOT, dialect
from fleet.gcs.bridge import Bridge
from fleet.gcs.items import E7, Item
from fleet.gcs.sysids import Sysids
from fleet.gcs.wishes import Done, Wish
from fleet.mission.model import Mission
from fleet.operator.view import BoatView
from fleet.wire.messages import FleetEvent, Revision
from tests.wire.samples import STATE, STATUS

MAVLINK = dialect()
LAT, LON = 44.38, 8.93
NORTH = 1.0 / 111_195.0  # a metre, in degrees of latitude
STEP_S = 0.05


class GroundStation:
    """Speaks under its own number from its own address."""

    def __init__(self, deck: Deck, number: int = 0, sysid: int = 255) -> None:
        self.deck, self.peer = deck, (number, None)
        self.codec = MAVLINK.MAVLink(None, srcSystem=sysid, srcComponent=190)
        self.heard: list[Any] = []
        self._reader = MAVLINK.MAVLink(None)

    def say(self, name: str, *fields: Any) -> None:
        """A message by its name."""
        frame = bytes(getattr(MAVLINK, f"MAVLink_{name}_message")(*fields).pack(self.codec))
        self.codec.seq = (self.codec.seq + 1) % 256
        self.deck.hear(self.peer, frame)

    def command(self, sysid: int, number: int, *params: float) -> None:
        """A COMMAND_LONG."""
        self.say("command_long", sysid, 1, number, 0, *(*params, *(0.0,) * 7)[:7])

    def mode(self, sysid: int, mode: int) -> None:
        """DO_SET_MODE."""
        self.command(sysid, 176, 1, mode)

    def set(self, sysid: int, name: str, value: float) -> None:
        """PARAM_SET."""
        self.say("param_set", sysid, 1, name.encode(), value, 9)

    def read(self, datagram: bytes) -> None:
        """What arrives."""
        message = self._reader.decode(bytearray(datagram))
        self.heard.append(message)

    def all(self, kind: str, sysid: int | None = None) -> list[Any]:
        """Messages of a kind that arrived since `clear`, of one vehicle."""
        return [m for m in self.heard if m.get_type() == kind and sysid in (None, m.get_srcSystem())]

    def last(self, kind: str, sysid: int | None = None) -> Any:
        """The last of them."""
        found = self.all(kind, sysid)
        assert found, f"no {kind} of {sysid}: {[m.get_type() for m in self.heard]}"
        return found[-1]

    def texts(self, sysid: int | None = None) -> list[str]:
        """STATUSTEXTs, pieces joined."""
        joined: list[str] = []
        for m in self.all("STATUSTEXT", sysid):
            if m.id and m.chunk_seq:
                joined[-1] += m.text
            else:
                joined.append(m.text)
        return joined

    def clear(self) -> None:
        """What was heard is forgotten."""
        self.heard.clear()

    def upload(self, sysid: int, items: list[Item] | tuple[Item, ...]) -> int:
        """The whole protocol; the result, or -1 where there is none yet."""
        self.clear()
        self.say("mission_count", sysid, 1, len(items), 0)
        asked = 0
        while self.all("MISSION_REQUEST_INT", sysid)[asked:] and not self.all("MISSION_ACK", sysid):
            asked = len(self.all("MISSION_REQUEST_INT", sysid))
            self.send_item(sysid, items[self.last("MISSION_REQUEST_INT", sysid).seq])
        acks = self.all("MISSION_ACK", sysid)
        return acks[-1].type if acks else -1

    def send_item(self, sysid: int, item: Item, mission_type: int = 0) -> None:
        """A MISSION_ITEM_INT."""
        head = (item.seq, item.frame, item.command, item.current, item.autocontinue)
        self.say("mission_item_int", sysid, 1, *head, *item.params, item.x, item.y, item.z, mission_type)

    def download(self, sysid: int) -> list[Any]:
        """All items."""
        self.clear()
        self.say("mission_request_list", sysid, 1, 0)
        for seq in range(self.last("MISSION_COUNT", sysid).count):
            self.say("mission_request_int", sysid, 1, seq, 0)
        return self.all("MISSION_ITEM_INT", sysid)


class Deck:
    """The bridge, its fleet, its ground stations."""

    def __init__(self, *boats: str, template: Mission | None = None, autopilot: int = ARDUPILOT) -> None:
        self.now_s = 100.0
        self.bridge = Bridge(MAVLINK, Sysids({}), operator="gcs", autopilot=autopilot, template=template)
        self.views = {
            boat: BoatView(boat, state(boat, i), status(boat), heard_s=self.now_s, alive=True)
            for i, boat in enumerate(boats)
        }
        self.dead: set[str] = set()
        self.events: list[FleetEvent] = []
        self.stations: list[GroundStation] = []
        self.wishes: list[Wish] = []
        self.station = self.join()
        self.run(2.0)
        self.station.clear()

    def join(self, sysid: int = 255) -> GroundStation:
        """One more ground station."""
        self.stations.append(GroundStation(self, len(self.stations), sysid))
        return self.stations[-1]

    def hear(self, peer: Any, frame: bytes) -> None:
        """A datagram."""
        self.bridge.hear(peer, frame, self.now_s)
        self.flush()

    def flush(self) -> None:
        """Deliver."""
        self.wishes += self.bridge.take_wishes()
        for peer, datagram in self.bridge.take_outbox():
            for station in self.stations:
                if peer in (None, station.peer):
                    station.read(datagram)

    def run(self, seconds: float = STEP_S) -> None:
        """Time passes; boats go on saying what they say."""
        for _ in range(round(seconds / STEP_S)):
            self.now_s += STEP_S
            for view in self.views.values():
                if view.name not in self.dead:
                    view.heard_s = self.now_s
            events, self.events = self.events, []
            self.bridge.look(self.views, events, self.now_s)
            self.bridge.step(self.now_s)
            self.flush()

    def wish(self, kind: str) -> Wish:
        """The one wish that waits."""
        kinds = [wish.kind for wish in self.wishes]
        assert kinds == [kind], kinds
        return self.wishes.pop()

    def answer(self, wish: Wish, ok: bool = True, text: str = "", *, silent: bool = False, value: Any = None) -> None:
        """The fleet has done it, or not."""
        self.bridge.done(Done(wish.number, ok, text, silent, value), self.now_s)
        self.flush()

    def does(self, kind: str, ok: bool = True, text: str = "", value: Any = None) -> Wish:
        """It is wished and done."""
        wish = self.wish(kind)
        self.answer(wish, ok, text, value=value)
        return wish

    def sails(self, mission: Mission, mission_id: str = "1000-gcs", mode: Mode = Mode.FOLLOW) -> None:
        """All boats of a roster hold a mission and sail it."""
        formation = mission.formation
        for boat in mission.boats:
            view = self.views[boat.name]
            assert view.state is not None
            assert view.status is not None
            self.change(boat.name, mode=int(mode), mission_id=mission_id)
            view.status = structs.replace(
                view.status,
                mission_id=mission_id,
                pattern=formation.pattern,
                spacing_m=formation.spacing_m,
                lateral_m=formation.lateral_m or formation.spacing_m,
                cruise_mps=formation.cruise_mps,
                slot=boat.slot,
            )
        if mission_id not in self.bridge.shared.plans:
            self.run()
            for wish in [w for w in self.wishes if w.kind == "look"]:
                self.wishes.remove(wish)
                self.answer(wish, value=(mission_id, mission))

    def change(self, boat: str, **fields: Any) -> None:
        """The boat says something else from now on."""
        view = self.views[boat]
        assert view.state is not None
        view.state = structs.replace(view.state, **fields)


def state(boat: str, number: int) -> Any:
    """A boat that waits, 15 m north of the one before."""
    return structs.replace(
        STATE,
        boat=boat,
        lat_deg=LAT + 15.0 * number * NORTH,
        lon_deg=LON,
        mode=int(Mode.STANDBY),
        reasons=0,
        stops=(),
        mission_id="",
        control=Revision(),
        foreign=None,
    )


def status(boat: str) -> Any:
    """The same in words."""
    return structs.replace(STATUS, boat=boat, mission_id="", pattern="", battery_percent=80.0)


def waypoint(seq: int, north_m: float, east_m: float, command: int = 16, frame: int = 3) -> Item:
    """An item so far from the boats' first place."""
    lat, lon = LAT + north_m * NORTH, LON + east_m * NORTH / 0.7147
    return Item(seq, frame, command, 0, 1, (0.0, 0.0, 0.0, 0.0), round(lat * E7), round(lon * E7), 5.5)


def mission(*points: tuple[float, float]) -> list[Item]:
    """Home and waypoints, metres north and east."""
    return [waypoint(i, *point) for i, point in enumerate(((0.0, 0.0), *points))]
