import numpy as np

from a2s_drake import Scenario
from a2s_drake.world.ship_motion import ShipMotion
from diagrams import build_closed_loop, build_link_only


def test_the_antenna_stands_upright_above_the_reference_point() -> None:
    dut = ShipMotion(10.31)
    context = dut.CreateDefaultContext()
    dut.GetInputPort("ship_position").FixValue(context, [90.0, 3.0, -20.0])
    np.testing.assert_allclose(dut.GetOutputPort("ship_antenna_position").Eval(context), [90.0, 3.0, -9.69])


def test_an_error_of_height_moves_the_antenna_and_nothing_that_the_law_reads(scenario: Scenario) -> None:
    for build in (build_closed_loop, build_link_only):
        seen = {}
        for error in (0.0, 0.31):
            dut = build(scenario.with_value("knowledge.ship_antenna_height_error", error))
            context = dut.CreateDefaultContext()
            names = ("ship_antenna_position", "ship_position", "ship_preview", "attitude_reference", "snr_db")
            seen[error] = {name: dut.GetOutputPort(name).Eval(context).copy() for name in names}
        np.testing.assert_allclose(seen[0.31]["ship_antenna_position"][2], -9.69, rtol=1e-15)
        for name in ("ship_position", "ship_preview", "attitude_reference"):
            np.testing.assert_array_equal(seen[0.0][name], seen[0.31][name])
        assert abs(seen[0.0]["snr_db"] - seen[0.31]["snr_db"]) > 0.1
