import numpy as np
import pytest

from a2s_drake import Scenario, ScenarioError
from a2s_drake.flight.feasible import check


def test_by_default_the_truth_is_what_is_believed() -> None:
    assert Scenario().true_link() == Scenario().link


def test_truth_is_belief_and_error() -> None:
    dut = Scenario().with_overrides(
        ["knowledge.ship_antenna_height_error=0.31", "knowledge.transmit_power_error_db=-6"]
    )
    truth = dut.true_link()
    assert (truth.ship_antenna_height, truth.transmit_power_dbm) == (10.31, 4.0)
    assert dut.link == Scenario().link


def test_bias_of_the_pose_is_in_si_units() -> None:
    dut = Scenario().with_overrides(
        ["knowledge.position_bias=[0.1, 0.2, -0.3]", "knowledge.attitude_bias_deg=[90, 0, -45]"]
    )
    np.testing.assert_allclose(dut.knowledge.pose_bias, [0.1, 0.2, -0.3, np.pi / 2.0, 0.0, -np.pi / 4.0])


@pytest.mark.parametrize(
    ("override", "reason"),
    [
        ("knowledge.ship_antenna_height_error=-10", "must leave the ship's antenna, believed 10.0 m above the sea"),
        ("knowledge.position_bias=[0, 0, -19.99]", "the UAV then flies 0.01 m above the sea"),
        ("knowledge.position_bias=[0, 0]", "must have 3 entries"),
        ("knowledge.ship_latency=-1", "at least 0"),
        ("knowledge.ship_antenna_height_error=.nan", "must be finite"),
    ],
)
def test_what_cannot_be_true_is_refused(override: str, reason: str) -> None:
    with pytest.raises(ScenarioError) as refusal:
        check(Scenario().with_overrides([override]))
    assert str(refusal.value).startswith(override.partition("=")[0] + " = ")
    assert reason in str(refusal.value)
