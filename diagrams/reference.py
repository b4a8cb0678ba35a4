"""The part that the drawings share: path, ship and law, wired up."""

from pydrake.systems.framework import DiagramBuilder, System

from a2s_drake.common.wiring import check_ports
from a2s_drake.guidance.path import UavPath
from a2s_drake.guidance.plan.block import PlannedReference
from a2s_drake.guidance.plan.cache import kept_plan
from a2s_drake.guidance.soft_min import AttitudeReference
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.world.ship import ShipTrajectory


def add_reference(
    builder: DiagramBuilder, scenario: Scenario, law: System | None = None
) -> tuple[System, System, System]:
    """Adds `uav_path`, `ship` and `attitude_reference`, wired, with their present values exported.

    Args:
      law: a block with the ports of `AttitudeReference` to stand in for the scenario's law.
    Raises:
      WiringError: when that block lacks one of these ports, or has it in another size.
    """
    mpc = scenario.mpc
    size = 3 * (mpc.horizon + 1)
    if law is None:
        law = _own_law(scenario)
    inputs, outputs = (
        {"position_preview": size, "ship_preview": size},
        {"attitude_reference": 3, "attitude_preview": size},
    )
    check_ports("attitude_reference", law, inputs, outputs)
    path = builder.AddNamedSystem("uav_path", UavPath(scenario.mission, mpc))
    ship = builder.AddNamedSystem("ship", ShipTrajectory(scenario.mission, mpc))
    builder.AddNamedSystem("attitude_reference", law)
    builder.Connect(path.GetOutputPort("position_preview"), law.GetInputPort("position_preview"))
    builder.Connect(ship.GetOutputPort("ship_preview"), law.GetInputPort("ship_preview"))
    for block, port in ((path, "position_reference"), (law, "attitude_reference"), (ship, "ship_position")):
        builder.ExportOutput(block.GetOutputPort(port), port)
    return path, ship, law


def _own_law(scenario: Scenario) -> System:
    """The block of the scenario's law; a plan that is not kept yet is made now."""
    mpc = scenario.mpc
    if scenario.attitude_law.name == "planned":
        return PlannedReference(kept_plan(scenario), scenario.airframe, scenario.mission, mpc)
    return AttitudeReference(scenario.link, scenario.attitude_law, mpc.attitude_limit, mpc.horizon)
