"""The part that the drawings share: path, ship and law, wired up."""

from pydrake.systems.framework import DiagramBuilder, LeafSystem

from a2s_drake.attitude_law import AttitudeReference
from a2s_drake.paths import ShipTrajectory, UavPath
from a2s_drake.scenario import Scenario


def add_reference(builder: DiagramBuilder, scenario: Scenario) -> tuple[LeafSystem, LeafSystem, LeafSystem]:
    """Adds `uav_path`, `ship` and `attitude_reference`, wired, with their present values exported."""
    path = builder.AddNamedSystem("uav_path", UavPath(scenario.mission, scenario.mpc))
    ship = builder.AddNamedSystem("ship", ShipTrajectory(scenario.mission, scenario.mpc))
    mpc = scenario.mpc
    law = builder.AddNamedSystem(
        "attitude_reference",
        AttitudeReference(scenario.link, scenario.attitude_law, mpc.attitude_limit, mpc.horizon),
    )
    builder.Connect(path.GetOutputPort("position_preview"), law.GetInputPort("position_preview"))
    builder.Connect(ship.GetOutputPort("ship_preview"), law.GetInputPort("ship_preview"))
    for block, port in ((path, "position_reference"), (law, "attitude_reference"), (ship, "ship_position")):
        builder.ExportOutput(block.GetOutputPort(port), port)
    return path, ship, law
