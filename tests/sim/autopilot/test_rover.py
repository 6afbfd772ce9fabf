"""The simulated autopilot has the habits that were observed of ArduPilot Rover."""

from __future__ import annotations

from typing import Any

import pytest

from fleet.drivers.mavlink import words
from fleet.drivers.mavlink.frames import Frames
from fleet.drivers.mavlink.talk import Talk
from fleet.sim.autopilot.guided import Aim, Refused, aim_of
from fleet.sim.autopilot.hull import Senses
from fleet.sim.autopilot.rover import Rover
from fleet.sim.autopilot.telemetry import speak

MAVLINK = words.dialect()
BEGIN_NS = 1_700_000_000_000_000_000
AHEAD = Senses(44.38, 8.93, 0.0, 1.0, 0.0, 0.0, 1.0)


class Lab:
    """A Rover, somebody who talks to it, and a clock."""

    def __init__(self, running_s: float = 100.0, own: int = 255) -> None:
        self.now_ns, self.senses = BEGIN_NS, AHEAD
        self.rover = Rover(MAVLINK, BEGIN_NS, AHEAD, running_s=running_s)
        self.talk = Talk(MAVLINK, own, 1)
        self.said: list[Any] = []
        self.thrust = self.rover.step(self.now_ns, AHEAD)
        self.tell(self.talk.heartbeat())

    def tell(self, frame: bytes) -> Any:
        """Say something; the acknowledgement, if any."""
        before = len(self.said)
        for message in Frames(MAVLINK).datagram(frame):
            self.rover.hear("me", message)
        self.listen()
        acks = [m for m in self.said[before:] if m.get_type() == "COMMAND_ACK"]
        return acks[-1].result if acks else None

    def listen(self) -> None:
        self.said += [message for _, message in speak(self.rover)]

    def run(self, seconds: float, *, frame: bytes = b"", every_s: float = 0.1) -> None:
        for k in range(round(seconds * 20)):
            if frame and k % round(every_s * 20) == 0:
                self.tell(frame)
            self.now_ns += 50_000_000
            self.thrust = self.rover.step(self.now_ns, self.senses)
            self.listen()

    def texts(self) -> list[str]:
        return [m.text.decode() if isinstance(m.text, bytes) else m.text for m in self.of("STATUSTEXT")]

    def of(self, kind: str) -> list[Any]:
        return [m for m in self.said if m.get_type() == kind]

    def guided(self) -> None:
        assert self.tell(self.talk.set_mode(words.GUIDED)) == words.ACCEPTED
        assert self.tell(self.talk.arm(True)) == words.ACCEPTED


def test_a_mode_asked_for_while_it_starts_is_acknowledged_and_forgotten() -> None:
    lab = Lab(running_s=0.0)
    assert lab.tell(lab.talk.set_mode(words.GUIDED)) == words.ACCEPTED
    assert lab.of("HEARTBEAT")[-1].custom_mode == words.INITIALISING
    lab.run(7.0)
    assert lab.of("HEARTBEAT")[-1].custom_mode == words.MANUAL


def test_manual_arms_without_a_position_and_guided_is_then_refused() -> None:
    lab = Lab(running_s=0.0)
    lab.run(24.0)
    assert lab.of("SYS_STATUS")[-1].onboard_control_sensors_health & words.PRE_ARM
    assert lab.tell(lab.talk.arm(True)) == words.ACCEPTED
    assert lab.tell(lab.talk.set_mode(words.GUIDED)) == words.FAILED


def test_the_checks_are_judged_for_the_mode_that_it_is_in() -> None:
    lab = Lab(running_s=0.0)
    lab.run(24.0)
    assert lab.tell(lab.talk.set_mode(words.GUIDED)) == words.ACCEPTED
    lab.run(2.0)
    assert not lab.of("SYS_STATUS")[-1].onboard_control_sensors_health & words.PRE_ARM
    assert lab.tell(lab.talk.arm(True)) == words.FAILED
    assert lab.texts()[-1] == "Arm: Need Position Estimate"
    lab.run(18.0)
    assert lab.tell(lab.talk.arm(True)) == words.ACCEPTED


@pytest.mark.parametrize("mode", [11, 12])
def test_modes_that_cannot_be_armed_say_so(mode: int) -> None:
    lab = Lab()
    lab.tell(lab.talk.set_mode(mode))
    assert lab.tell(lab.talk.arm(True)) == words.FAILED
    assert lab.texts()[-1] == "Arm: Mode not armable"


def test_set_points_outside_guided_vanish() -> None:
    lab = Lab()
    assert lab.tell(lab.talk.arm(True)) == words.ACCEPTED
    lab.run(1.0, frame=lab.talk.setpoint(0, 1.0, 0.0))
    assert (lab.thrust.powered, lab.rover.dropped) == (False, 10)
    assert not lab.of("COMMAND_ACK")[1:], "nothing is said about it"


def test_speed_is_clamped_to_wp_speed() -> None:
    lab = Lab()
    lab.guided()
    lab.tell(lab.talk.set_parameter("WP_SPEED", 0.5))
    lab.senses = Senses(44.38, 8.93, 0.0, 0.5, 0.0, 0.0, 0.5)
    lab.run(1.0, frame=lab.talk.setpoint(0, 10.0, 0.1))
    assert lab.thrust.surge_mps == pytest.approx(0.5, abs=0.1)


def test_without_a_set_point_for_three_seconds_it_stops_and_says_so() -> None:
    lab = Lab()
    lab.guided()
    lab.run(3.0, frame=lab.talk.setpoint(0, 1.0, 0.0))
    lab.run(2.8)
    assert lab.thrust.surge_mps > 0.9
    lab.run(0.3)
    assert lab.thrust.surge_mps == pytest.approx(0.0, abs=0.05)
    assert lab.texts()[-1] == "target not received last 3secs, stopping"
    assert (lab.rover.mode, lab.rover.armed) == (words.GUIDED, True)


def test_a_third_of_a_set_point_a_second_still_holds() -> None:
    lab = Lab()
    lab.guided()
    lab.run(12.0, frame=lab.talk.setpoint(0, 1.0, 0.0), every_s=2.9)
    assert "stopping" not in " ".join(lab.texts())


def test_masks_decide_what_is_taken() -> None:
    assert aim_of(8, 0x5C7, 1.0, 0.0, 0.0, 0.2) == Aim(1.0, 0.2)
    assert aim_of(8, 0x5C7, -1.0, 0.0, 0.0, 0.2) == Aim(-1.0, 0.2), "astern"
    assert aim_of(8, 0x5C7 | 0x10, 1.0, 0.0, 0.0, 0.2) == Aim(0.0, 0.2), "half a velocity is none"
    assert aim_of(1, 0xDC7, 0.0, 2.0, 0.0, 0.0) == Aim(2.0, course_rad=pytest.approx(1.5707963))
    assert aim_of(1, 0x9C7, 1.0, 0.0, 0.3, 0.0) == Aim(1.0, course_rad=0.3)
    with pytest.raises(Refused, match=r"^$"):
        aim_of(12, 0x5C7, 1.0, 0.0, 0.0, 0.2)
    with pytest.raises(Refused, match=r"^$"):
        aim_of(8, 0x1C7, 1.0, 0.0, 0.3, 0.2)
    with pytest.raises(Refused, match="set ACC_IGNORE in mask"):
        aim_of(8, 0x5C7 & ~0x40, 1.0, 0.0, 0.0, 0.2)


def test_the_ground_station_failsafe_takes_six_and_a_half_seconds_and_guided_does_not_come_back_by_itself() -> None:
    lab = Lab()
    lab.rover.parameters["FS_GCS_ENABLE"] = 1
    lab.guided()
    lab.tell(lab.talk.heartbeat())
    lab.run(6.4, frame=lab.talk.setpoint(0, 1.0, 0.0))
    assert lab.rover.mode == words.GUIDED
    lab.run(0.3, frame=lab.talk.setpoint(0, 1.0, 0.0))
    assert lab.rover.mode == words.HOLD
    assert not lab.thrust.powered, "though set-points still flow"
    assert "Radio Failsafe" in lab.texts()
    lab.run(2.0, frame=lab.talk.heartbeat(), every_s=1.0)
    assert lab.rover.mode == words.HOLD
    assert lab.tell(lab.talk.set_mode(words.GUIDED)) == words.ACCEPTED


def test_heartbeats_of_another_sysid_do_not_count_and_the_failsafe_is_off_by_default() -> None:
    for own, enabled in ((254, 1.0), (255, 0.0)):
        lab = Lab(own=own)
        lab.rover.parameters["FS_GCS_ENABLE"] = enabled
        lab.guided()
        lab.run(20.0, frame=lab.talk.setpoint(0, 1.0, 0.0))
        assert lab.rover.mode == words.GUIDED


def test_before_a_fix_the_position_is_zero_zero() -> None:
    lab = Lab(running_s=0.0)
    lab.run(30.0)
    assert {(m.lat, m.lon) for m in lab.of("GLOBAL_POSITION_INT")} == {(0, 0)}
    assert lab.of("EKF_STATUS_REPORT")[0].flags == 0x400
    lab.run(20.0)
    assert lab.of("GLOBAL_POSITION_INT")[-1].lat == 443800000
    assert lab.of("EKF_STATUS_REPORT")[-1].flags == 0x33F


def test_eight_seconds_after_the_loss_of_gnss_the_estimator_fails_and_the_velocity_still_shows_one() -> None:
    lab = Lab()
    lab.guided()
    lab.run(2.0, frame=lab.talk.setpoint(0, 1.0, 0.0))
    lab.senses = Senses(44.3801, 8.93, 0.0, 0.0, 0.0, 0.0, 0.0, fix=False)
    lab.run(8.0, frame=lab.talk.setpoint(0, 1.0, 0.0))
    assert lab.rover.mode == words.GUIDED
    lab.run(1.0, frame=lab.talk.setpoint(0, 1.0, 0.0))
    assert lab.rover.mode == words.HOLD
    assert lab.texts()[-2:] == ["EKF variance", "EKF failsafe"]
    lab.run(4.0)
    assert lab.of("HEARTBEAT")[-1].system_status == words.CRITICAL
    assert lab.of("EKF_STATUS_REPORT")[-1].flags == 0xA7
    assert lab.of("GLOBAL_POSITION_INT")[-1].vx == 100


def test_more_than_25_hz_is_denied_and_the_old_rate_stays() -> None:
    lab = Lab()
    assert lab.tell(lab.talk.rate(words.ATTITUDE, 10.0)) == words.ACCEPTED
    assert lab.tell(lab.talk.rate(words.ATTITUDE, 50.0)) == words.DENIED
    lab.said.clear()
    lab.run(5.0)
    assert len(lab.of("ATTITUDE")) == pytest.approx(50, abs=1)


def test_a_reboot_forgets_rates_and_starts_the_time_anew() -> None:
    lab = Lab()
    lab.tell(lab.talk.rate(words.ATTITUDE, 10.0))
    lab.run(2.0)
    before = lab.of("ATTITUDE")[-1].time_boot_ms
    assert lab.tell(lab.talk.command(246, 1.0)) == words.ACCEPTED
    lab.said.clear()
    lab.run(5.0)
    assert len(lab.of("ATTITUDE")) == pytest.approx(5, abs=1)
    assert lab.of("ATTITUDE")[-1].time_boot_ms < 6000 < before


def test_a_parameter_is_set_unchecked_and_an_unknown_one_gets_no_answer() -> None:
    lab = Lab()
    lab.tell(lab.talk.set_parameter("WP_SPEED", -5.0))
    assert lab.of("PARAM_VALUE")[-1].param_value == -5.0
    lab.said.clear()
    lab.tell(lab.talk.ask_parameter("NO_SUCH"))
    assert not lab.of("PARAM_VALUE")
    lab.tell(lab.talk.ask_parameter("FRAME_CLASS"))
    told = lab.of("PARAM_VALUE")[-1]
    assert (told.param_id, told.param_value, told.param_index) == ("FRAME_CLASS", 2.0, 65535)


def test_what_it_does_not_know_is_unsupported_and_a_foreign_sysid_gets_silence() -> None:
    lab = Lab()
    assert lab.tell(lab.talk.command(187)) == words.UNSUPPORTED
    assert lab.tell(Talk(MAVLINK, 255, 9).command(187)) is None
    assert lab.tell(Talk(MAVLINK, 255, 0).command(187)) == words.UNSUPPORTED
