"""The hexarotor alone, its rotors open to the user: hover it, linearise it, differentiate it."""

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder

from a2s_drake.common.wiring import build_wired, export_outputs, mark_own_blocks
from a2s_drake.flight import feasible
from a2s_drake.guidance.courses import Courses
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.vehicle.airframe import add_airframe


def build_airframe_only(scenario: Scenario | None = None) -> Diagram:
    """Plant, propellers and state adapter of a scenario (Table I by default). Converts to AutoDiffXd.

    ```
                           +---------------+
                           |               |--> vehicle_state
    rotor_speed_squared -->| airframe_only |
                           |               |--> body_poses
                           +---------------+
    ```
    """
    scenario = (scenario or Scenario()).validate()
    courses = Courses.of(scenario)
    feasible.check(scenario, courses)
    builder = DiagramBuilder()
    start = courses.uav.position(np.array(0.0))
    airframe = add_airframe(builder, scenario.airframe, start.tolist(), scenario.disturbance)
    builder.ExportInput(airframe.GetInputPort("rotor_speed_squared"), "rotor_speed_squared")
    export_outputs(builder, airframe)
    diagram = build_wired(builder, "airframe_only")
    mark_own_blocks(diagram, {})
    return diagram
