import numpy as np
import pytest
from pydrake.math import RollPitchYaw

from a2s_drake import Scenario, run_flight
from a2s_drake.study.ideal_tracking import Geometry, IdealTracking, measure_ideal_tracking, phase_errors
from a2s_drake.study.paper.errata import errata
from diagrams import build_link_only


@pytest.fixture(scope="module")
def study() -> IdealTracking:
    return measure_ideal_tracking(Scenario())


def test_ideal_tracking_of_table_i(study: IdealTracking) -> None:
    assert study.level_throughput_bit_per_hz == pytest.approx(122.387, abs=5e-4)
    gains = study.gain_percent["three_axis"]
    assert gains == pytest.approx({"nearest": 44.9, "index_zero": 44.5, "zero": 16.2}, abs=0.1)


def test_no_law_beats_the_ceiling_and_hover_costs_something(study: IdealTracking) -> None:
    ceiling = study.ceiling_percent
    assert ceiling.box > ceiling.hoverable
    assert all(gain < ceiling.box for gains in study.gain_percent.values() for gain in gains.values())


def test_empty_sets_of_table_i(study: IdealTracking) -> None:
    assert study.empty_share == pytest.approx({"three_axis": 0.285, "pitch_only": 0.629}, abs=0.001)


def test_phase_error_shrinks_quadratically_with_the_box() -> None:
    scenario = Scenario().with_value("simulation.duration", 1.0)
    small = scenario.with_value("mpc.attitude_limit_deg", 1.5)
    large_error, small_error = (np.abs(phase_errors(s, Geometry.of(s))).max() for s in (scenario, small))
    assert large_error / small_error == pytest.approx(100.0, rel=0.25)


@pytest.fixture(scope="module")
def figures() -> list[dict[str, float]]:
    return [{label: value for label, value, _ in erratum.figures} for erratum in errata(Scenario())]


def test_errata_show_their_numbers(figures: list[dict[str, float]]) -> None:
    sign, heights, empty, projection, jumps, start, lift = figures
    assert sign == pytest.approx({"gain if followed": 5.0, "gain mended": 44.9}, abs=0.1)
    assert list(heights.values()) == pytest.approx([1.3, 3.0, 44.9], abs=0.1)
    assert list(empty.values()) == pytest.approx([15.0, 20.9, 42.95], abs=0.05)
    # (86 pi) / ||k|| at most, with ||k|| of about 6.9 rad/rad.
    assert projection.pop("largest norm of eta_0") == pytest.approx(40.0, abs=1.0)
    assert list(projection.values()) == pytest.approx([44.5, 44.9, 9.5, 33.9], abs=0.1)
    assert list(jumps.values()) == pytest.approx([30.0, 30.0, 15.0], abs=0.2)
    assert start["step of the acceleration"] == pytest.approx(31.00627668 * 2.65 / 1600.0)
    assert list(lift.values()) == pytest.approx([0.6625, 66.25, 2.57 * 9.81], rel=1e-3)


def test_candidate_box_that_is_never_empty_is_just_wide_enough(figures: list[dict[str, float]]) -> None:
    for label, law in (("box needed for three axes", "three_axis"), ("for pitch only", "pitch_only")):
        for factor, empty in ((1.001, False), (0.999, True)):
            scenario = Scenario().with_value("attitude_law.candidate_limit_deg", factor * figures[2][label])
            assert (measure_ideal_tracking(scenario).empty_share[law] > 0.0) == empty


def law_by_hand(fallback: str) -> float:
    """Gain of the three-axis law over level from the paper's words alone: plain loops, k by differences."""
    wavelength, box = 299792458.0 / 3e9, np.deg2rad(15.0)
    throughput = {"law": 0.0, "level": 0.0}
    for n in range(2001):
        angle = np.pi * (1.0 - np.cos(np.pi * n / 2000.0))
        uav = np.array([2.65 * np.cos(angle) - 2.65, 2.65 * np.sin(angle), 0.0])
        ship = np.array([90.0 + 10.0 * n / 2000.0, 0.0, -20.0])

        def rays(eta: np.ndarray, uav: np.ndarray = uav, ship: np.ndarray = ship) -> tuple[float, float]:
            antenna = uav + RollPitchYaw(eta).ToRotationMatrix().matrix() @ [0.39, 0.39, 0.195]
            up = np.array([0.0, 0.0, 10.0])
            return np.linalg.norm(ship + up - antenna), np.linalg.norm(ship - up - antenna)

        def phase(eta: np.ndarray) -> float:
            d_los, d_ref = rays(eta)
            return 2.0 * np.pi / wavelength * (d_ref - d_los)

        k = np.array([(phase(1e-5 * e) - phase(-1e-5 * e)) / 2e-5 for e in np.eye(3)])
        candidates = [((2 * m + 1) * np.pi - phase(np.zeros(3))) * k / (k @ k) for m in range(-50, 51)]
        feasible = [eta for eta in candidates if np.abs(eta).max() <= box]
        if feasible:
            weights = [np.exp(-7.0 * (eta @ eta)) for eta in feasible]
            reference = sum(w * eta for w, eta in zip(weights, feasible, strict=True)) / sum(weights)
        elif fallback == "zero":
            reference = np.zeros(3)
        else:
            nearest = min(candidates, key=np.linalg.norm) if fallback == "nearest" else candidates[50]
            reference = np.clip(nearest, -box, box)
        for name, eta in (("law", reference), ("level", np.zeros(3))):
            d_los, d_ref = rays(eta)
            g = wavelength / (4.0 * np.pi) * (1.0 / d_los - 0.8 / d_ref * np.exp(-1j * phase(eta)))
            throughput[name] += np.log2(1.0 + 1e9 * abs(g) ** 2)
    return 100.0 * (throughput["law"] / throughput["level"] - 1.0)


@pytest.mark.parametrize("fallback", ["nearest", "zero", "index_zero"])
def test_ideal_tracking_agrees_with_the_law_by_hand(fallback: str, study: IdealTracking) -> None:
    assert study.gain_percent["three_axis"][fallback] == pytest.approx(law_by_hand(fallback), abs=1e-3)


def test_what_the_uav_does_not_know_costs_the_laws_and_not_the_ceilings(scenario: Scenario) -> None:
    # The oracle is the drawing that holds the reference exactly.
    coarse = ["mpc.period=0.4", "mpc.horizon=2"]
    wrong = ["knowledge.ship_antenna_height_error=0.1", "knowledge.attitude_bias_deg=[0.5, -0.5, 0]"]
    known, unknown = (scenario.with_overrides([*coarse, *more]) for more in ([], wrong))
    knows, guesses = map(measure_ideal_tracking, (known, unknown))
    flown = {
        law: run_flight(build_link_only(one), one).spectral_efficiency.sum() * 0.4
        for law in ("three_axis", "level")
        for one in [unknown.with_value("attitude_law.name", law)]
    }
    assert guesses.level_throughput_bit_per_hz == pytest.approx(flown["level"], rel=1e-12)
    expected = 100.0 * (flown["three_axis"] / flown["level"] - 1.0)
    assert guesses.gain_percent["three_axis"]["nearest"] == pytest.approx(expected, abs=1e-9)
    assert guesses.gain_percent["three_axis"]["nearest"] < 0.5 * knows.gain_percent["three_axis"]["nearest"]
    assert guesses.ceiling_percent.box > 0.8 * knows.ceiling_percent.box
