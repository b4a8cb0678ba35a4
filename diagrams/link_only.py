"""The link of a vehicle that is always exactly where and how it should be: no dynamics, no controller."""

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, Multiplexer

from a2s_drake.common.wiring import NamedWiring
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.scenario.scenario import Scenario

from .blocks import Blocks, Maker
from .roles import NAMES

_EXPORTED = (
    *("vehicle_state", "position_reference", "attitude_reference", "ship_position", "ship_antenna_position"),
    *("channel_gain", "snr_db", "spectral_efficiency", "phase_difference", "reflection", "ship_preview"),
)

_ROLES = ("path", "ship", "ship_motion", "ship_report", "law", "channel")


def build_link_only(
    scenario: Scenario | None = None, *, blocks: Blocks | None = None, plan: AttitudeSpline | None = None
) -> Diagram:
    """Ideal tracking of a scenario (Table I by default); the vehicle's velocities read zero.

    What the UAV believes of its own pose is exactly the reference. Where it is biased (`knowledge.position_bias`,
    `knowledge.attitude_bias_deg`), its true pose is the reference and the bias.

    ```
    +-----------+
    |           |--> vehicle_state, measured_state
    | link_only |--> position_reference, attitude_reference
    |           |--> ship_position, ship_antenna_position, ship_preview
    |           |--> channel_gain, snr_db, spectral_efficiency, phase_difference, reflection
    +-----------+
    ```

    Args:
      blocks: factories of the user's own path, ship, ship motion, ship report, law and channel. This drawing has no
        place for other roles.
      plan: as for `build_closed_loop`.
    Raises:
      ScenarioError: when the scenario cannot be flown.
      WiringError: when a block's ports do not fit; names them, with the sizes found and wanted.
    """
    scenario = scenario or Scenario()
    maker = Maker(scenario, blocks or Blocks(), plan)
    maker.refuse_others("link_only", _ROLES)
    path, ship = maker.make("path"), maker.make("ship")
    maker.check(path, ship)
    builder = DiagramBuilder()
    wiring = NamedWiring(builder)
    wiring.add(NAMES["path"], path)
    wiring.add(NAMES["ship"], ship)
    if not maker.tells_of_itself(ship):
        wiring.add(NAMES["ship_report"], maker.make_ship_report(ship))
    law = wiring.add(NAMES["law"], maker.make("law"))
    wiring.add(NAMES["ship_motion"], maker.make("ship_motion"))
    wiring.add("velocities", ConstantVectorSource(np.zeros(6)), outputs={"y0": "velocities"})
    position = maker.moved_position(law).get("position_reference", "position_reference")
    pose = {"u0": position, "u1": "attitude_reference", "u2": "velocities"}
    bias = np.array([*scenario.knowledge.pose_bias, *[0.0] * 6])
    if bias.any():
        measured = wiring.add("measured_state", Multiplexer([3, 3, 6]), pose, {"y0": "measured_state"})
        wiring.add("pose_bias", ConstantVectorSource(bias), outputs={"y0": "pose_bias"})
        truth = {"u0": "measured_state", "u1": "pose_bias"}
        wiring.add("vehicle_state", Adder(2, 12), truth, {"sum": "vehicle_state"})
    else:
        measured = wiring.add("vehicle_state", Multiplexer([3, 3, 6]), pose, {"y0": "vehicle_state"})
    wiring.add(NAMES["channel"], maker.make("channel"))
    wiring.export(outputs={*_EXPORTED, *maker.own_outputs})
    builder.ExportOutput(measured.get_output_port(), "measured_state")
    return maker.build(builder, "link_only")
