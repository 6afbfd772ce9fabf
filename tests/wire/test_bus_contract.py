"""What every bus promises: the one in memory, and Zenoh on loopback through a hub and routed from boat to boat."""

from __future__ import annotations

import contextlib
import socket
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import zenoh

from fleet.wire import keys
from fleet.wire.bus import Answer, Bus, Heard
from fleet.wire.link import LinkConfig
from fleet.wire.memory_bus import MemoryBus, Water
from fleet.wire.zenoh_bus import ZenohBus
from fleet.wire.zenoh_link import session_config
from fleet.wire.zenoh_shore import OperatorBus

PATIENCE_S = 15.0
NAMES = ("a", "b", "c")


def wait_for(condition: Callable[[], Any], what: str = "") -> Any:
    """The first true value of the condition; fails when it does not come."""
    deadline = time.monotonic() + PATIENCE_S
    while not (value := condition()):
        assert time.monotonic() < deadline, f"never: {what or condition}"
        time.sleep(0.005)
    return value


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class MemoryNet:
    """Stations in one process."""

    def __init__(self) -> None:
        self._water = Water(time.time_ns)
        self._buses: list[MemoryBus] = []

    def boat(self, name: str) -> Bus:
        """A boat's end, not yet open."""
        self._buses.append(MemoryBus(self._water, name))
        return self._buses[-1]

    twin = boat

    def aboard(self, name: str, what: str, payload: bytes) -> None:
        """Somebody on board of a boat publishes under its name."""
        self._water.boats[name].deposit_own(what, payload)

    def cut(self) -> None:
        """What joins the boats fails."""
        for bus in self._buses:
            bus.cut = True

    def mend(self) -> None:
        """And works again."""
        for bus in self._buses:
            bus.cut = False

    @contextlib.contextmanager
    def operator(self, name: str) -> Iterator[None]:
        """Somebody ashore."""
        self._water.operators.add(name)
        yield
        self._water.operators.discard(name)

    def close(self) -> None:
        """All stations leave."""
        for bus in self._buses:
            bus.close()


class HubNet:
    """Zenoh: a router that boats and operators connect to."""

    _aboard: Any = None

    def __init__(self) -> None:
        self._at = f"tcp/127.0.0.1:{free_port()}"
        self._stations: list[Any] = []
        self._hub: Any = None
        self.mend()

    def _link(self, name: str) -> LinkConfig:  # noqa: ARG002
        return LinkConfig(topology="hub", connect=(self._at,), lease_ms=1000)

    def boat(self, name: str) -> Bus:
        """A boat's end, not yet open."""
        self._stations.append(ZenohBus("test", name, self._link(name), time.time_ns))
        return self._stations[-1]

    twin = boat

    def aboard(self, name: str, what: str, payload: bytes) -> None:
        """Somebody on board of a boat publishes under its name."""
        if self._aboard is None:
            self._aboard = wait_for(lambda: zenoh.open(session_config("client", self._link_of_operator())))
        self._aboard.put(keys.key("test", name, what), payload)

    def cut(self) -> None:
        """The hub dies."""
        self._hub.close()

    def mend(self) -> None:
        """The hub is started again at its old place."""
        config = session_config("router", LinkConfig(topology="hub", listen=(self._at,), lease_ms=1000))

        def opened() -> Any:
            with contextlib.suppress(zenoh.ZError):
                return zenoh.open(config)

        self._hub = wait_for(opened, "the hub's port is free")

    @contextlib.contextmanager
    def operator(self, name: str) -> Iterator[None]:
        """Somebody ashore."""
        bus = OperatorBus("test", name, self._link_of_operator())
        assert bus.open(PATIENCE_S)
        yield
        bus.close()

    def _link_of_operator(self) -> LinkConfig:
        return LinkConfig(topology="hub", connect=(self._at,), lease_ms=1000)

    def close(self) -> None:
        """All stations leave."""
        if self._aboard is not None:
            self._aboard.close()
        for station in self._stations:
            station.close()
        if self._hub is not None:
            self._hub.close()


class RoutedNet(HubNet):
    """Zenoh: every boat's session is a router that knows the others' addresses."""

    def __init__(self) -> None:
        self._ports = {name: free_port() for name in (*NAMES, "twin")}
        self._far: dict[str, ZenohBus] = {}
        self._stations = []
        self._hub = None

    def _link(self, name: str) -> LinkConfig:
        others = tuple(f"tcp/127.0.0.1:{port}" for other, port in self._ports.items() if other not in (name, "twin"))
        return LinkConfig(
            topology="routed", connect=others, listen=(f"tcp/127.0.0.1:{self._ports[name]}",), lease_ms=1000
        )

    def twin(self, name: str) -> Bus:
        """Another machine under the same name."""
        self._stations.append(ZenohBus("test", name, self._link("twin"), time.time_ns))
        return self._stations[-1]

    def cut(self) -> None:
        """All boats but the first go out of reach."""
        for station in self._stations[1:]:
            station.close()

    def mend(self) -> None:
        """One of them comes back."""
        back = self.boat("b")
        wait_for(back.open)

    def _link_of_operator(self) -> LinkConfig:
        return LinkConfig(topology="hub", connect=(f"tcp/127.0.0.1:{self._ports['a']}",), lease_ms=1000)


Net = MemoryNet | HubNet | RoutedNet


@pytest.fixture(params=[MemoryNet, HubNet, RoutedNet], ids=["memory", "hub", "routed"])
def net(request: pytest.FixtureRequest) -> Iterator[Net]:
    made = request.param()
    yield made
    made.close()


def opened(net: Net, *names: str) -> list[Any]:
    """Boats that are open and announced, and see each other's tokens."""
    buses = [net.boat(name) for name in names]
    for bus in buses:
        wait_for(bus.open, "open")
    for bus in buses:
        bus.announce()
    for bus, name in zip(buses, names, strict=True):
        wait_for(lambda bus=bus, name=name: bus.alive() >= set(names) - {name}, "alive")  # type: ignore[misc]
        for other in names:
            bus.watch(other)
    return buses


def first_from(hearer: Bus, speaker: Bus, name: str, payload: bytes = b"first") -> None:
    """Speak until it is heard: the subscription has found its publisher."""

    def heard() -> bool:
        speaker.put_state(payload)
        return any(m.sender == name for m in hearer.poll_states(256))

    wait_for(heard, f"hear {name}")
    settle(hearer)


def settle(hearer: Bus) -> None:
    """Nothing more is on its way."""
    quiet = 0

    def still() -> bool:
        nonlocal quiet
        quiet = 0 if hearer.poll_states(256) else quiet + 1
        return quiet > 5

    wait_for(still, "silence")


# -- states ------------------------------------------------------------------------------------------------------------
def test_states_arrive_under_their_senders_name_oldest_first(net: Net) -> None:
    a, b = opened(net, "a", "b")
    first_from(a, b, "b")
    heard: list[Heard] = []
    before = time.time_ns()
    for k in range(50):
        b.put_state(b"%d" % k)
    wait_for(lambda: heard.extend(a.poll_states(256)) or (heard and heard[-1].payload == b"49"))
    assert [int(m.payload) for m in heard] == sorted(int(m.payload) for m in heard)
    assert {m.sender for m in heard} == {"b"}
    assert all(before <= m.at_ns <= time.time_ns() for m in heard)


def test_a_boat_does_not_hear_itself(net: Net) -> None:
    a, b = opened(net, "a", "b")
    first_from(b, a, "a")
    assert a.poll_states(256) == []


def test_only_who_is_watched_is_heard(net: Net) -> None:
    a, b, c = opened(net, "a", "b", "c")
    first_from(a, b, "b")
    first_from(a, c, "c")
    a.unwatch("c")
    c.put_state(b"x")
    b.put_state(b"last")
    heard: list[Heard] = []
    wait_for(lambda: heard.extend(a.poll_states(256)) or any(m.payload == b"last" for m in heard))
    assert {m.sender for m in heard} == {"b"}


def test_what_somebody_on_board_publishes_is_kept_the_newest_eight_and_for_that_boat_only(net: Net) -> None:
    a, b = net.boat("a"), net.boat("b")
    for bus in (a, b):
        bus.listen_own("scan")
    for bus in (a, b):
        wait_for(bus.open, "open")

    def hears(payload: bytes) -> bool:
        net.aboard("a", "scan", payload)  # said again, since it may be dropped
        heard = a.poll_own("scan")
        assert len(heard) <= 8
        assert all(one.sender == "a" for one in heard)
        return any(one.payload == payload for one in heard)

    wait_for(lambda: hears(b"first"))
    for k in range(20):
        net.aboard("a", "scan", b"%d" % k)
    wait_for(lambda: hears(b"last"))
    assert b.poll_own("scan") == []
    assert a.poll_own("what nobody listens to") == []


def test_no_more_than_the_bound_is_handed_over_for_each_sender(net: Net) -> None:
    a, b = opened(net, "a", "b")
    first_from(a, b, "b")
    for k in range(20):
        b.put_state(b"%d" % k)
    batches: list[list[Heard]] = []
    wait_for(lambda: batches.append(a.poll_states(3)) or any(m.payload == b"19" for m in batches[-1]))
    assert max(map(len, batches)) <= 3


def test_a_flood_of_one_does_not_evict_another(net: Net) -> None:
    a, b, c = opened(net, "a", "b", "c")
    first_from(a, b, "b")
    first_from(a, c, "c")
    b.put_state(b"mine")
    for k in range(3000):
        c.put_state(b"flood %d" % k)
    b.put_state(b"mine too")
    heard: list[Heard] = []
    wait_for(
        lambda: heard.extend(a.poll_states(256)) or [m.payload for m in heard if m.sender == "b"][-1:] == [b"mine too"]
    )
    assert [m.payload for m in heard if m.sender == "b"] == [b"mine", b"mine too"]


def test_of_a_flood_the_newest_are_kept(net: Net) -> None:
    a, b = opened(net, "a", "b")
    first_from(a, b, "b")
    for k in range(1500):
        b.put_state(b"%d" % k)
    time_over = time.monotonic() + PATIENCE_S
    newest = -1
    while newest < 1499:
        assert time.monotonic() < time_over
        b.put_state(b"1499")  # best effort: what was dropped on the way is no fault of the ring
        newest = max([newest, *(int(m.payload) for m in a.poll_states(256))])


# -- questions ---------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("what", keys.ASKED)
def test_a_question_is_answered(net: Net, what: str) -> None:
    a, b = opened(net, "a", "b")
    answers: list[Answer] = []

    def answered() -> bool:
        a.ask("b", what, b"question")
        for request in b.poll_requests(16):
            assert (request.what, request.payload) == (what, b"question")
            request.reply(b"answer")
        answers.extend(a.poll_answers())
        return bool(answers)

    wait_for(answered, "an answer")
    assert answers[0] == Answer("b", what, b"answer")


def test_a_question_may_be_left_unanswered(net: Net) -> None:
    a, b = opened(net, "a", "b")

    def dropped() -> bool:
        a.ask("b", keys.ECHO, b"")
        requests = b.poll_requests(16)
        for request in requests:
            request.drop()
        return bool(requests)

    wait_for(dropped)
    assert a.poll_answers() == []


def test_a_question_to_nobody_is_not_answered_and_does_not_wait(net: Net) -> None:
    (a,) = opened(net, "a")
    began = time.monotonic()
    for _ in range(10):
        a.ask("nobody", keys.ECHO, b"")
    assert time.monotonic() - began < 0.5
    assert a.poll_answers() == []


def test_no_more_requests_than_the_bound_are_handed_over(net: Net) -> None:
    a, b = opened(net, "a", "b")
    for _ in range(10):
        a.ask("b", keys.ECHO, b"")
    got: list[int] = []

    def all_got() -> bool:
        requests = b.poll_requests(3)
        for request in requests:
            request.reply(b"")
        got.append(len(requests))
        return sum(got) == 10

    wait_for(all_got)
    assert max(got) <= 3


def test_an_answer_does_not_pass_through_a_link_that_is_cut(net: Net) -> None:
    a, b = opened(net, "a", "b")
    requests: list[Any] = []

    def asked() -> bool:
        a.ask("b", keys.ECHO, b"")
        requests.extend(b.poll_requests(16))
        return bool(requests)

    wait_for(asked)
    net.cut()
    wait_for(lambda: not a.link_up(), "down")
    for request in requests:
        request.reply(b"too late")
    assert a.poll_answers() == []


# -- who is there ------------------------------------------------------------------------------------------------------
def test_boats_are_alive_from_their_announcement_to_their_end_and_oneself_is_not_counted(net: Net) -> None:
    a, b = opened(net, "a", "b")
    assert a.alive() == {"b"}
    b.close()
    wait_for(lambda: a.alive() == frozenset(), "b is gone")


def test_a_boat_that_has_not_announced_itself_is_not_alive(net: Net) -> None:
    a, b = opened(net, "a", "b")
    c = net.boat("c")
    wait_for(c.open)
    c.watch("b")
    first_from(c, b, "b")
    assert a.alive() == {"b"}


def test_a_name_that_is_in_use_is_found_out(net: Net) -> None:
    opened(net, "a", "b")
    twin = net.twin("b")
    wait_for(twin.open)
    wait_for(lambda: not twin.alone_with_my_name(), "the other is seen")


def test_a_name_that_is_free_is_free(net: Net) -> None:
    opened(net, "a")
    c = net.boat("c")
    wait_for(c.open)
    assert c.alone_with_my_name()


def test_operators_are_seen_come_and_go(net: Net) -> None:
    (a,) = opened(net, "a")
    assert a.operators() == frozenset()
    with net.operator("anna"):
        wait_for(lambda: a.operators() == {"anna"}, "anna")
        assert a.alive() == frozenset(), "an operator is no boat"
    wait_for(lambda: a.operators() == frozenset(), "anna is gone")


# -- the link ----------------------------------------------------------------------------------------------------------
def test_the_link_is_down_when_what_joins_the_boats_dies_and_up_again_after(net: Net) -> None:
    a, _ = opened(net, "a", "b")
    wait_for(a.link_up, "up")
    net.cut()
    wait_for(lambda: not a.link_up(), "down")
    a.put_state(b"nobody hears it, and nobody raises")
    a.ask("b", keys.ECHO, b"")
    assert a.poll_states(256) == []
    net.mend()
    wait_for(a.link_up, "up again")


def test_states_flow_again_after_the_link_was_down(net: Net) -> None:
    if isinstance(net, RoutedNet):
        pytest.skip("there, a boat itself went")
    a, b = opened(net, "a", "b")
    first_from(a, b, "b")
    net.cut()
    wait_for(lambda: not a.link_up() and not b.link_up())
    net.mend()
    first_from(a, b, "b", b"again")
    wait_for(lambda: a.alive() == {"b"}, "its token is back")


def test_before_it_is_open_nothing_raises_and_nothing_is_heard(net: Net) -> None:
    bus = net.boat("a")
    bus.watch("b")
    bus.put_state(b"x")
    bus.put(keys.STATUS, b"x")
    bus.ask("b", keys.ECHO, b"")
    assert not bus.link_up()
    assert bus.poll_states(9) == bus.poll_requests(9) == bus.poll_answers() == []
    assert bus.alive() == bus.operators() == frozenset()


def test_opening_never_blocks_though_nobody_is_there() -> None:
    bus = ZenohBus("test", "a", LinkConfig(topology="hub", connect=(f"tcp/127.0.0.1:{free_port()}",)), time.time_ns)
    began = time.monotonic()
    for _ in range(5):
        assert not bus.open()
    assert time.monotonic() - began < 0.5
    bus.close()


def test_an_operator_hears_boats_before_and_after_the_hub_was_started_again() -> None:
    net = HubNet()
    try:
        (boat,) = opened(net, "a")
        shore = OperatorBus("test", "anna", net._link_of_operator())
        assert shore.open(PATIENCE_S)
        shore.listen((keys.STATE, keys.STATUS))

        def hears() -> bool:
            boat.put_state(b"state")
            boat.put(keys.STATUS, b"status")
            return {("state", "a", b"state"), ("status", "a", b"status")} <= set(shore.heard())

        wait_for(hears, "heard")
        wait_for(lambda: shore.alive() == {"a"}, "alive")
        wait_for(hears, "heard by the number of its key")
        net.cut()
        wait_for(lambda: not boat.link_up(), "cut")
        net.mend()
        wait_for(boat.link_up, "mended")
        wait_for(lambda: shore.alive() == {"a"}, "alive again")
        shore.heard()
        wait_for(hears, "heard again")
        shore.close()
    finally:
        net.close()
