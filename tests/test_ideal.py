import numpy as np
import pytest

from a2s_drake import Scenario
from a2s_drake.errata import errata
from a2s_drake.ideal import Geometry, ideal_study, phase_errors


@pytest.fixture(scope="module")
def study() -> dict:
    return ideal_study(Scenario())


def test_ideal_tracking_of_table_i(study: dict) -> None:
    assert study["level_throughput_bit_per_hz"] == pytest.approx(122.387, abs=5e-4)
    gains = study["gain_percent"]["three_axis"]
    assert gains == pytest.approx({"nearest": 44.9, "index_zero": 44.5, "zero": 16.2}, abs=0.1)


def test_no_law_beats_the_ceiling_and_hover_costs_something(study: dict) -> None:
    ceiling = study["ceiling_percent"]
    assert ceiling["box"] > ceiling["hoverable"]
    assert all(gain < ceiling["box"] for gains in study["gain_percent"].values() for gain in gains.values())


def test_empty_sets_of_table_i(study: dict) -> None:
    assert study["empty_share"] == pytest.approx({"three_axis": 0.285, "pitch_only": 0.629}, abs=0.001)


def test_phase_error_shrinks_quadratically_with_the_box() -> None:
    scenario = Scenario().with_value("simulation.duration", 1.0)
    small = scenario.with_value("mpc.attitude_limit_deg", 1.5)
    large_error, small_error = (np.abs(phase_errors(s, Geometry.of(s))).max() for s in (scenario, small))
    assert large_error / small_error == pytest.approx(100.0, rel=0.25)


def test_errata_show_their_numbers() -> None:
    dut = {erratum.name + erratum.where: erratum for erratum in errata(Scenario())}
    followed = [erratum.followed for erratum in errata(Scenario())]
    here = [erratum.here for erratum in errata(Scenario())]
    assert len(dut) >= 5
    # The sign slip: 5 % instead of 45 %; the literal heights; the smallest box that is never empty.
    assert (followed[0], here[0]) == pytest.approx((5.0, 44.9), abs=0.1)
    assert here[2] > 15.0
    # The reference jumps from bound to bound within one period: 30 deg in 20 ms.
    assert here[4] == pytest.approx(np.deg2rad(30.0) / 0.02)
    # pi^3 R / T^2.
    assert here[5] == pytest.approx(31.00627668 * 2.65 / 1600.0)


def test_candidate_box_that_is_never_empty_is_just_wide_enough() -> None:
    wide = next(erratum.here for erratum in errata(Scenario()) if erratum.name == "half-width of the box")
    for factor, empty in ((1.001, False), (0.999, True)):
        scenario = Scenario().with_value("attitude_law.candidate_limit_deg", factor * wide)
        assert (ideal_study(scenario)["empty_share"]["three_axis"] > 0.0) == empty
