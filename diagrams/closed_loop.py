"""The whole mission in one loop: the world, what is sensed of it, and what flies on board."""

from collections.abc import Callable

from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import PassThrough

from a2s_drake.common.wiring import (
    NamedWiring,
    WiringError,
    build_wired,
    connect_fitting,
    input_ports,
    output_ports,
)
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.vehicle.actuators import InputDelay
from a2s_drake.vehicle.airframe import hover_input

from .blocks import Blocks, Maker
from .roles import NAMES

# What a drawing exports, where one of its parts gives it.
_EXPORTED = (
    *("vehicle_state", "body_poses", "rotor_speed_squared"),
    *("position_reference", "position_command", "attitude_reference", "ship_position", "ship_antenna_position"),
    *("channel_gain", "snr_db", "spectral_efficiency", "phase_difference", "reflection"),
    *("measured_state", "ship_preview", "snr_measurement", "phasor", "force_estimate"),
    *("predicted_state", "solver_status"),
)


def build_closed_loop(
    scenario: Scenario | None = None,
    *,
    blocks: Blocks | None = None,
    plan: AttitudeSpline | None = None,
    prebuild: Callable[[DiagramBuilder], None] | None = None,
) -> Diagram:
    """The mission of a scenario (Table I by default), the vehicle at rest and level where the path begins.

    It holds three diagrams. `world` is the truth, `onboard` is what the UAV knows and decides, and `sensing` is all
    that connects the first with the second. `rotor_speed_squared` is the command that reaches the rotors.

    ```
    +-------------+
    |             |--> vehicle_state, rotor_speed_squared, body_poses
    |             |--> position_reference, attitude_reference
    | closed_loop |--> ship_position, ship_antenna_position
    |             |--> channel_gain, snr_db, spectral_efficiency, phase_difference, reflection
    |             |--> measured_state, ship_preview
    |             |--> predicted_state, solver_status
    +-------------+
    ```

    Args:
      blocks: factories of the user's own blocks; outputs of theirs with other names are exported too.
      plan: what the law flies, where `attitude_law.name` is `planned`; see `kept_plan`. Without it the diagram can be
        drawn, but not simulated.
      prebuild: called with the builder before the diagram is built, when `world`, `sensing` and `onboard` are in it and
        wired: to add systems, wires and outputs of the user's own.
    Raises:
      ScenarioError: when the scenario cannot be flown.
      WiringError: when a block's ports do not fit; names them, with the sizes found and wanted.
    """
    scenario = scenario or Scenario()
    maker = Maker(scenario, blocks or Blocks(), plan)
    path, ship = maker.make("path"), maker.make("ship")
    maker.check(path, ship)
    world = _build_world(scenario, maker, path, ship)
    sensing = _build_sensing(maker, ship, world)
    onboard = _build_onboard(maker, path, sensing)

    builder = DiagramBuilder()
    for part in (world, sensing, onboard):
        builder.AddSystem(part)
    _connect_by_name(builder, world, sensing)
    _connect_by_name(builder, sensing, onboard)
    _connect_by_name(builder, onboard, world)
    exported: set[str] = set()
    for part in (world, sensing, onboard):
        for port in output_ports(part):
            name = port.get_name()
            if name not in exported and (name in _EXPORTED or name in maker.own_outputs):
                builder.ExportOutput(port, name)
                exported.add(name)
    if prebuild is not None:
        prebuild(builder)
    opened_by = None if prebuild is None else getattr(prebuild, "__name__", type(prebuild).__name__)
    return maker.build(builder, "closed_loop", opened_by=opened_by)


def _build_world(scenario: Scenario, maker: Maker, path: System, ship: System) -> Diagram:
    """The truth: the vehicle, the ship, and the link between both."""
    builder = DiagramBuilder()
    wiring = NamedWiring(builder)
    delay = scenario.disturbance.input_delay_periods
    if delay:
        late = InputDelay(delay, scenario.mpc.period, hover_input(scenario.airframe))
        wiring.add("input_delay", late, {"rotor_speed_command": "rotor_speed_squared"})
    wiring.add(NAMES["airframe"], maker.make_airframe(path))
    wiring.add(NAMES["ship"], ship)
    wiring.add(NAMES["ship_motion"], maker.make("ship_motion"))
    wiring.add(NAMES["channel"], maker.make("channel"))
    wiring.export()
    return build_wired(builder, "world")


def _build_sensing(maker: Maker, ship: System, world: Diagram) -> Diagram:
    """The sensors: all that the UAV knows of the world."""
    builder = DiagramBuilder()
    wiring = NamedWiring(builder)
    wiring.add(NAMES["navigation"], maker.make("navigation"))
    if maker.tells_of_itself(ship):
        told = PassThrough(ship.GetOutputPort("ship_preview").size())
        wiring.add(NAMES["ship_report"], told, {"u": "ship_preview"}, {"y": "ship_preview"})
    else:
        wiring.add(NAMES["ship_report"], maker.make_ship_report(ship))
    if maker.has("receiver"):
        wiring.add(NAMES["receiver"], maker.make("receiver"))
    wiring.export(world)
    return build_wired(builder, "sensing")


def _build_onboard(maker: Maker, path: System, sensing: Diagram) -> Diagram:
    """What the UAV decides, from what its sensors tell."""
    builder = DiagramBuilder()
    wiring = NamedWiring(builder)
    measured = {"vehicle_state": "measured_state"}
    wiring.add(NAMES["path"], path, measured)
    if maker.has("observer"):
        wiring.add(NAMES["observer"], maker.make("observer"), measured)
    law = wiring.add(NAMES["law"], maker.make("law"), measured)
    wiring.add(NAMES["controller"], maker.make_controller(law), measured | maker.moved_position(law))
    wiring.export(sensing)
    return build_wired(builder, "onboard")


def _connect_by_name(builder: DiagramBuilder, source: Diagram, target: Diagram) -> None:
    """Connects every input of a part to the output of the same name of another."""
    for port in input_ports(target):
        if not source.HasOutputPort(port.get_name()):
            raise WiringError(f"{target.get_name()}: input {port.get_name()}: {source.get_name()} does not give it")
        connect_fitting(builder, source.GetOutputPort(port.get_name()), port, target.get_name())
