"""The blocks of a drawing by role: ours for a scenario, or the user's own in their places."""

from collections.abc import Callable
from dataclasses import dataclass

from pydrake.systems.framework import System

from a2s_drake.common.wiring import check_ports, class_name
from a2s_drake.control.controller import MpcController, feedforward_ports
from a2s_drake.guidance.laws import build_law
from a2s_drake.guidance.path import UavPath
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.link.two_ray import TwoRayChannel
from a2s_drake.navigation.sensors import NavigationSensor
from a2s_drake.navigation.ship_report import ShipReport
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.vehicle.airframe import make_airframe
from a2s_drake.world.ship import ShipTrajectory, ship_track
from a2s_drake.world.ship_motion import ShipMotion

Factory = Callable[[Scenario], System]
"""Makes a block for a scenario, a new one at each call."""


@dataclass(frozen=True)
class Blocks:
    """One factory for each role of a drawing; None stands for this library's block.

    `Blocks(law=lambda scenario: MyLaw())` puts a law of the user's own into a drawing. Inputs are wired by name: a
    block gets the signal that an input of it is called after. Onboard blocks get what sensors and other onboard blocks
    give, never the truth; an input `vehicle_state` of theirs is the measured state.

    Attributes:
      path: onboard. Outputs `position_reference` (3), `position_preview` (3(N+1)).
      ship: world. Output `ship_position` (3). The UAV is told the track of a `ShipTrajectory`. A block of another kind
        may have an output `ship_preview` (3(N+1)) to tell of itself; without it the UAV believes the scenario's track.
      ship_motion: world. Output `ship_antenna_position` (3).
      channel: world. Outputs `channel_gain`, `snr_db`, `spectral_efficiency`, `phase_difference` (1 each).
      navigation: sensing. Output `measured_state` (12).
      ship_report: sensing. Output `ship_preview` (3(N+1)).
      receiver: sensing; there is none of ours yet. Output `snr_measurement` (2): dB, and its time stamp, s.
      observer: onboard, between the sensors and the law; there is none of ours yet. Its outputs reach the law and the
        controller by their names.
      law: onboard. Outputs `attitude_reference` (3), `attitude_preview` (3(N+1)).
      controller: onboard. Output `rotor_speed_squared` (6).
      airframe: world. Input `rotor_speed_squared` (6), output `vehicle_state` (12).
    """

    path: Factory | None = None
    ship: Factory | None = None
    ship_motion: Factory | None = None
    channel: Factory | None = None
    navigation: Factory | None = None
    ship_report: Factory | None = None
    receiver: Factory | None = None
    observer: Factory | None = None
    law: Factory | None = None
    controller: Factory | None = None
    airframe: Factory | None = None


NAMES = {
    "path": "uav_path",
    "ship": "ship",
    "ship_motion": "ship_motion",
    "channel": "channel",
    "navigation": "navigation_sensor",
    "ship_report": "ship_report",
    "receiver": "snr_receiver",
    "observer": "observer",
    "law": "attitude_reference",
    "controller": "mpc",
    "airframe": "airframe",
}
"""What the block of each role is called in a drawing."""

_OURS: dict[str, Factory] = {
    "path": lambda scenario: UavPath(scenario.mission, scenario.mpc),
    "ship": lambda scenario: ShipTrajectory(scenario.mission),
    "ship_motion": lambda scenario: ShipMotion(scenario.true_link().ship_antenna_height),
    "channel": lambda scenario: TwoRayChannel(scenario.true_link(), scenario.mission.sea_level),
    "navigation": lambda scenario: NavigationSensor(scenario.mpc.period, scenario.disturbance, scenario.knowledge),
}


class Maker:
    """Makes the blocks of one drawing, and remembers which of them, and which of their outputs, are the user's own."""

    def __init__(self, scenario: Scenario, blocks: Blocks, plan: AttitudeSpline | None = None) -> None:
        """A maker for a scenario, with the user's factories and the plan of its law, if it needs one."""
        self._scenario, self._blocks, self._plan = scenario, blocks, plan
        self.own: dict[str, str] = {}
        self.own_outputs: set[str] = set()

    def has(self, role: str) -> bool:
        """Whether the user gives a factory for a role."""
        return getattr(self._blocks, role) is not None

    def make(self, role: str) -> System:
        """The block of a role, checked.

        Raises:
          WiringError: when a block of the user's own lacks a port of its role, or has it in another size.
        """
        own: Factory | None = getattr(self._blocks, role)
        if own is None:
            return build_law(self._scenario, self._plan) if role == "law" else _OURS[role](self._scenario)
        block = own(self._scenario)
        check_ports(NAMES[role], block, {}, self._outputs(role))
        self.own[role] = block.get_name() or class_name(block)
        self.own_outputs |= {block.get_output_port(i).get_name() for i in range(block.num_output_ports())}
        return block

    def make_controller(self, law: System) -> System:
        """The controller, which follows the rates and inputs that a law plans beyond the attitude, where it does."""
        if self.has("controller"):
            return self.make("controller")
        scenario, feeds = self._scenario, feedforward_ports(self._scenario.mpc)
        fed = scenario.mpc.feedforward and any(map(law.HasOutputPort, feeds))
        if fed:
            check_ports(NAMES["law"], law, {}, feeds)
        return MpcController(scenario.airframe, scenario.mpc, feedforward=fed)

    def make_ship_report(self, ship: System) -> System:
        """What the UAV is told of the ship: the track of our ship, or, for a ship of another kind, the scenario's."""
        if self.has("ship_report"):
            return self.make("ship_report")
        mpc, latency = self._scenario.mpc, self._scenario.knowledge.ship_latency
        track = ship.track if isinstance(ship, ShipTrajectory) else ship_track(self._scenario.mission)
        return ShipReport(track.position, mpc.period, mpc.horizon, latency)

    def make_airframe(self, path: System) -> System:
        """The airframe, level and at rest where a path begins."""
        if self.has("airframe"):
            return self.make("airframe")
        start = path.GetOutputPort("position_reference").Eval(path.CreateDefaultContext())
        return make_airframe(self._scenario.airframe, start.tolist(), self._scenario.disturbance)

    def _outputs(self, role: str) -> dict[str, int]:
        """The outputs that a block of a role must have, by name and size."""
        preview = 3 * (self._scenario.mpc.horizon + 1)
        return {
            "path": {"position_reference": 3, "position_preview": preview},
            "ship": {"ship_position": 3},
            "ship_motion": {"ship_antenna_position": 3},
            "channel": dict.fromkeys(("channel_gain", "snr_db", "spectral_efficiency", "phase_difference"), 1),
            "navigation": {"measured_state": 12},
            "ship_report": {"ship_preview": preview},
            "receiver": {"snr_measurement": 2},
            "observer": {},
            "law": {"attitude_reference": 3, "attitude_preview": preview},
            "controller": {"rotor_speed_squared": 6},
            "airframe": {"vehicle_state": 12},
        }[role]
