"""The blocks of a drawing by role: ours for a scenario, or the user's own in their places."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, System

from a2s_drake.common.wiring import (
    WiringError,
    build_wired,
    check_ports,
    class_name,
    mark_own_blocks,
    mark_track_files,
    output_ports,
)
from a2s_drake.control.controller import MpcController, feedforward_ports
from a2s_drake.flight import feasible
from a2s_drake.guidance.courses import Courses
from a2s_drake.guidance.laws import build_law, find_law
from a2s_drake.guidance.path import UavPath
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.link.two_ray import TwoRayChannel
from a2s_drake.navigation.sensors import NavigationSensor
from a2s_drake.navigation.ship_report import ShipReport
from a2s_drake.scenario.checks import ScenarioError, refuse
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.scenario.track_file import read_files
from a2s_drake.vehicle.airframe import make_airframe
from a2s_drake.world.ship import ShipTrajectory
from a2s_drake.world.ship_motion import ShipMotion

from .roles import NAMES, moved_position, roles

Factory = Callable[[Scenario], System]
"""Makes a block for a scenario, a new one at each call."""


@dataclass(frozen=True)
class Blocks:
    """One factory for each role of a drawing; None stands for this library's block.

    `Blocks(law=lambda scenario: MyLaw())` puts a law of the user's own into a drawing. Inputs are wired by name: a
    block gets the signal that an input of it is called after. Onboard blocks get what sensors and other onboard blocks
    give, never the truth; an input `vehicle_state` of theirs is the measured state.

    A factory gets the scenario, and what it does not read has no effect. So a channel of the user's own takes
    `scenario.true_link()`, which holds the errors of `knowledge`; a sensor takes the bias and the noise; and a ship
    motion the true height of the antenna.

    Attributes:
      path: onboard. Outputs `position_reference` (3), `position_preview` (3(N+1)). The vehicle starts where it begins,
        or, if it has inputs, where the scenario's path begins.
      ship: world. Output `ship_position` (3). The UAV is told the track of a `ShipTrajectory`. A block of another kind
        may have an output `ship_preview` (3(N+1)) to tell of itself; without it the UAV believes the scenario's track.
      ship_motion: world. Output `ship_antenna_position` (3).
      channel: world. Outputs `channel_gain`, `snr_db`, `spectral_efficiency`, `phase_difference` (1 each).
      navigation: sensing. Output `measured_state` (12).
      ship_report: sensing. Output `ship_preview` (3(N+1)).
      receiver: sensing; there is none of ours yet. Output `snr_measurement` (2): dB, and its time stamp, s.
      observer: onboard, between the sensors and the law; there is none of ours yet. Its outputs reach the law and the
        controller by their names.
      law: onboard. Outputs `attitude_reference` (3), `attitude_preview` (3(N+1)). With the outputs `position_command`
        (3) and `position_command_preview` (3(N+1)) the controller follows these, not the path.
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


def _has_all(law: System, ports: Mapping[str, int]) -> bool:
    """Whether a law has some outputs. A law that has one of them must have them all, or WiringError is raised."""
    if not any(map(law.HasOutputPort, ports)):
        return False
    check_ports(NAMES["law"], law, {}, ports)
    return True


class Maker:
    """Makes the blocks of one drawing, and remembers which of them, and which of their outputs, are the user's own."""

    def __init__(self, scenario: Scenario, blocks: Blocks, plan: AttitudeSpline | None = None) -> None:
        """A maker for a scenario, with the user's factories and the plan of its law, if it needs one.

        Raises:
          ScenarioError: when the plan is none for this scenario, or nobody would fly it; or a range is left.
        """
        self._scenario, self._blocks, self._plan = scenario.validate(), blocks, plan
        self._roles = roles(scenario.mpc)
        self._own: dict[str, str] = {}
        self._files = read_files(scenario.mission)
        self.own_outputs: dict[str, str] = {}
        self._check_plan()
        self._courses = Courses.of(scenario, self._files)

    def has(self, role: str) -> bool:
        """Whether the user gives a factory for a role."""
        return getattr(self._blocks, role) is not None

    def refuse_others(self, drawing: str, roles: Iterable[str]) -> None:
        """Raises WiringError where the user gives a block that a drawing has no place for."""
        others = [role for role in NAMES if self.has(role) and role not in roles]
        if others:
            raise WiringError(f"{drawing} has no place for: {', '.join(others)}")

    def check(self, path: System, ship: System) -> None:
        """Checks that a scenario can be flown, along the path and the track that these blocks serve.

        Raises:
          ScenarioError: see `a2s_drake.flight.feasible.check`.
        """
        blocks = {"path": (path, UavPath), "ship": (ship, ShipTrajectory)}
        unknown = {role for role, (block, kind) in blocks.items() if not isinstance(block, kind)}
        unknown |= {"law"} if self.has("law") else set()
        courses = Courses.along(
            self._scenario,
            path.motion if isinstance(path, UavPath) else self._courses.uav,
            ship.motion if isinstance(ship, ShipTrajectory) else self._courses.ship,
            "the path of Blocks.path" if self.has("path") else self._courses.uav_name,
            "the track of Blocks.ship" if self.has("ship") else self._courses.ship_name,
        )
        feasible.check(self._scenario, courses, unknown=unknown)

    def make(self, role: str) -> System:
        """The block of a role, checked.

        Raises:
          WiringError: when a block of the user's own is no block, or its ports do not fit its role.
        """
        return self._make_own(role) if self.has(role) else self._make_ours(role)

    def _make_ours(self, role: str) -> System:
        scenario = self._scenario
        if role == "path":
            return UavPath(self._courses.uav, scenario.mpc)
        if role == "ship":
            return ShipTrajectory(self._courses.ship)
        if role == "ship_motion":
            return ShipMotion(scenario.true_link().ship_antenna_height)
        if role == "channel":
            return TwoRayChannel(scenario.true_link(), scenario.mission.sea_level)
        if role == "navigation":
            return NavigationSensor(scenario.mpc.period, scenario.disturbance, scenario.knowledge)
        if role == "law":
            return build_law(scenario, self._plan)
        raise ValueError(f"{role}: there is no block of ours for this role alone")

    def _make_own(self, role: str) -> System:
        name, own = NAMES[role], getattr(self._blocks, role)
        if not callable(own):
            raise WiringError(f"{name}: Blocks.{role} must be a function that makes a block, is a {type(own).__name__}")
        block = own(self._scenario)
        if not isinstance(block, System):
            raise WiringError(f"{name}: Blocks.{role} must make a Drake System, made a {type(block).__name__}")
        outputs, ports = {port.get_name() for port in output_ports(block)}, self._roles[role]
        optional = {port: size for port, size in ports.may.items() if port in outputs and size is not None}
        check_ports(name, block, {}, {**ports.must, **optional})
        taken = {port for other in self._roles.values() for port in (*other.must, *other.may)}
        for port in sorted(outputs - ports.must.keys() - ports.may.keys()):
            if port in taken:
                raise WiringError(f"{name} ({class_name(block)}): output {port} is a signal of another role")
            if port in self.own_outputs:
                raise WiringError(f"{name} ({class_name(block)}): {self.own_outputs[port]} has an output {port} too")
            self.own_outputs[port] = name
        self._own[role] = block.get_name() or class_name(block)
        return block

    def make_controller(self, law: System) -> System:
        """The controller, which follows the rates and inputs that a law plans beyond the attitude, where it does."""
        if self.has("controller"):
            return self.make("controller")
        airframe, mpc = self._scenario.airframe, self._scenario.mpc
        return MpcController(airframe, mpc, feedforward=mpc.feedforward and _has_all(law, feedforward_ports(mpc)))

    def moved_position(self, law: System) -> dict[str, str]:
        """The signals that a controller follows in place of the path where a law moves the position, by input.

        Raises:
          WiringError: when a law has one of both outputs only.
        """
        if not _has_all(law, moved_position(self._scenario.mpc)):
            return {}
        return {"position_reference": "position_command", "position_preview": "position_command_preview"}

    def make_ship_report(self, ship: System) -> System:
        """What the UAV is told of the ship: the track of our ship, or, for a ship of another kind, the scenario's."""
        if self.has("ship_report"):
            return self.make("ship_report")
        mpc, latency = self._scenario.mpc, self._scenario.knowledge.ship_latency
        track = ship.motion if isinstance(ship, ShipTrajectory) else self._courses.ship
        return ShipReport(track.position, mpc.period, mpc.horizon, latency)

    def tells_of_itself(self, ship: System) -> bool:
        """Whether a ship brings a report of its own.

        Raises:
          ScenarioError: when it does, and the scenario wants that report to be late.
        """
        if self.has("ship_report") or not ship.HasOutputPort("ship_preview"):
            return False
        latency = self._scenario.knowledge.ship_latency
        if latency:
            raise refuse("knowledge.ship_latency", latency, "must be 0, as Blocks.ship brings a report of its own")
        return True

    def make_airframe(self, path: System) -> System:
        """The airframe, level and at rest where a path begins; where the scenario's does, if a path needs inputs."""
        if self.has("airframe"):
            return self.make("airframe")
        if path.num_input_ports():
            start = self._courses.uav.position(np.array(0.0))
        else:
            start = path.GetOutputPort("position_reference").Eval(path.CreateDefaultContext())
        return make_airframe(self._scenario.airframe, start.tolist(), self._scenario.disturbance)

    def build(self, builder: DiagramBuilder, name: str, *, opened_by: str | None = None) -> Diagram:
        """Builds the drawing, which then carries a note of the user's own blocks and of the track files it was made of.

        Args:
          opened_by: the name of a function of the user's own that has changed the drawing.
        """
        diagram = build_wired(builder, name)
        mark_own_blocks(diagram, self._own if opened_by is None else self._own | {"prebuild": opened_by})
        mark_track_files(diagram, self._files)
        return diagram

    def _check_plan(self) -> None:
        scenario, plan = self._scenario, self._plan
        name = scenario.attitude_law.name
        needs = find_law(name).needs_plan and not self.has("law")
        if needs:
            others = [f"Blocks.{role}" for role in ("path", "ship") if self.has(role)]
            if others:
                allowed = f"a plan is made for the scenario's own path and ship, not for {' and '.join(others)}"
                raise refuse("attitude_law.name", name, allowed)
        if plan is None:
            return
        if not needs:
            raise ScenarioError(f"plan: nothing in this diagram flies a plan; attitude_law.name = {name!r}")
        if plan.duration != scenario.mission.duration:
            words = f"plan: is for {plan.duration:g} s, must be for mission.duration"
            raise ScenarioError(f"{words} = {scenario.mission.duration!r} s")
        steepest = float(np.abs(plan.eta(scenario.samples_until(plan.duration))).max())
        if steepest > scenario.mpc.attitude_limit:
            words = f"plan: reaches {np.rad2deg(steepest):.4g} deg, must keep within mpc.attitude_limit_deg"
            raise ScenarioError(f"{words} = {scenario.mpc.attitude_limit_deg!r}")
