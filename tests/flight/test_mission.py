"""The main job end to end: the paper's mission through the Drake diagram, in closed loop."""

import numpy as np
import pytest

from a2s_drake import Flight, compute_metrics, run_flight
from a2s_drake.control.solve import WholeProgram, make_solver, solve_to_convergence
from a2s_drake.flight.log import array_names
from a2s_drake.flight.metrics import gain_percent
from a2s_drake.scenario.parts import PAPER_LAWS
from a2s_drake.scenario.scenario import Scenario
from diagrams import build_closed_loop
from tests.support.tracking import ROTOR_RANGE, hover_from, model_of, reference_at


@pytest.fixture
def calibrated(fly) -> dict[str, Flight]:
    return {
        "three_axis": fly("paper_calibrated"),
        "pitch_only": fly("paper_calibrated", "attitude_law.name=pitch_only"),
        "level": fly("paper_calibrated", "attitude_law.name=level"),
    }


@pytest.mark.parametrize(("baseline", "gain"), [("level", 22.5), ("pitch_only", 11.2)])
def test_headline_gains(baseline: str, gain: float, calibrated: dict[str, Flight]) -> None:
    # The figures of a simulation that shares no code with this one; the paper prints 22.2 and 11.4.
    assert gain_percent(calibrated["three_axis"], calibrated[baseline]) == pytest.approx(gain, abs=0.5)


def test_three_axes_keep_the_path(calibrated: dict[str, Flight]) -> None:
    assert compute_metrics(calibrated["three_axis"])["position_error_max_m"] <= 0.05


@pytest.mark.parametrize("law", PAPER_LAWS)
def test_every_law_stays_within_its_bounds_without_a_solver_failure(law: str, calibrated: dict[str, Flight]) -> None:
    metrics = compute_metrics(calibrated[law])
    assert (metrics["solver"]["failures"], metrics["solver"]["fallbacks"]) == (0, 0)
    assert metrics["bounds"]["rotor_speed"]["worst_excess"] == 0.0
    for bound in metrics["bounds"].values():
        assert bound["worst_excess_of_range"] <= 1e-3
    assert len(calibrated[law].time) == 2001
    assert (calibrated[law].rotor_speed >= 16.0).all()
    assert (calibrated[law].rotor_speed <= 100.0).all()


@pytest.mark.slow  # a reading of the machine, so not in the default suite
@pytest.mark.parametrize("law", PAPER_LAWS)
def test_every_law_flies_faster_than_real_time(law: str, calibrated: dict[str, Flight]) -> None:
    # About eight times on a machine that is left alone; the bound leaves room for one that is not.
    assert compute_metrics(calibrated[law])["real_time_factor"] > 2.5


def test_level_law_holds_level(calibrated: dict[str, Flight]) -> None:
    assert np.abs(calibrated["level"].attitude).max() < np.deg2rad(0.5)


def test_logged_channel_is_the_channel_of_the_logged_pose(calibrated: dict[str, Flight]) -> None:
    # From the log's pose by the paper's formulas, in complex numbers, apart from the library's own code.
    flight, link = calibrated["three_axis"], calibrated["three_axis"].scenario.link
    for k in range(0, 2001, 97):
        (cr, cp, cy), (sr, sp, sy) = np.cos(flight.attitude[k]), np.sin(flight.attitude[k])
        yaw = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        pitch = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        roll = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
        antenna = flight.position[k] + yaw @ pitch @ roll @ [0.39, 0.39, 0.195]
        ship = np.array([90.0 + 10.0 * flight.time[k] / 40.0, 0.0, -20.0])
        d_los, d_ref = (np.linalg.norm(ship + np.array([0.0, 0.0, z]) - antenna) for z in (10.0, -10.0))
        phase = 2.0 * np.pi / 0.1 * (d_ref - d_los)
        g = 0.1 / (4.0 * np.pi) * (1.0 / d_los + 0.8 / d_ref * np.exp(-1j * (phase + np.pi)))
        assert flight.channel_gain[k] == pytest.approx(abs(g) ** 2, rel=1e-9)
        assert flight.spectral_efficiency[k] == pytest.approx(np.log2(1.0 + 1e9 * abs(g) ** 2), rel=1e-9)
        assert link.wavelength == pytest.approx(0.1)


def test_a_run_repeated_from_its_own_yaml_is_the_same_bit_for_bit(fly) -> None:
    flight = fly("paper_calibrated", "simulation.duration=4.0")
    again = Scenario.from_yaml(flight.scenario.to_yaml()).validate()
    repeated = run_flight(build_closed_loop(again), again)
    for name in array_names():
        np.testing.assert_array_equal(getattr(repeated, name), getattr(flight, name))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "law", "gain", "error"),
    [
        ("paper", "three_axis", 30.98, 0.195),
        ("paper", "pitch_only", 22.31, 0.037),
        ("tilt35", "three_axis", 34.23, 0.038),
        ("tilt35", "pitch_only", 23.99, 0.033),
    ],
)
def test_figures_of_the_readme(name: str, law: str, gain: float, error: float, fly) -> None:
    flight, level = fly(name, f"attitude_law.name={law}"), fly(name, "attitude_law.name=level")
    metrics = compute_metrics(flight)
    assert gain_percent(flight, level) == pytest.approx(gain, abs=0.05)
    assert metrics["position_error_max_m"] == pytest.approx(error, abs=0.001)
    assert metrics["solver"]["failures"] == 0


@pytest.mark.slow
def test_solvers_of_the_qp_fly_alike(fly) -> None:
    piqp, osqp = (
        {law: fly("paper_calibrated", f"attitude_law.name={law}", f"mpc.solver={solver}") for law in PAPER_LAWS}
        for solver in ("piqp", "osqp")
    )
    for law, baseline in (("three_axis", "level"), ("three_axis", "pitch_only"), ("pitch_only", "level")):
        gains = [gain_percent(flights[law], flights[baseline]) for flights in (piqp, osqp)]
        assert gains[0] == pytest.approx(gains[1], abs=0.1)
    for law in PAPER_LAWS:
        np.testing.assert_allclose(piqp[law].position, osqp[law].position, atol=1e-4)


@pytest.mark.slow
def test_whole_program_flies_like_the_real_time_iteration(fly) -> None:
    # Four seconds hold the start's transient and a jump between fringes, the hardest parts for one QP a sample.
    whole = fly("paper_calibrated", "simulation.duration=4.0", "mpc.solver=ipopt")
    assert whole.solver_success.all()
    fastest = np.abs(np.diff(whole.attitude_reference, axis=0)).max() / whole.scenario.mpc.period
    assert fastest > whole.scenario.mpc.angular_velocity_limit
    for solver in ("piqp", "osqp"):
        rti = fly("paper_calibrated", "simulation.duration=4.0", f"mpc.solver={solver}")
        np.testing.assert_allclose(whole.position, rti.position, atol=2e-3)
        np.testing.assert_allclose(whole.attitude, rti.attitude, atol=np.deg2rad(0.1))


def state_at(flight: Flight, k: int) -> np.ndarray:
    return np.concatenate([flight.position[k], flight.attitude[k], flight.velocity[k], flight.angular_velocity[k]])


@pytest.mark.parametrize("sample", [0, 100, 194, 300, 478, 650, 805, 1000, 1325, 1879])
def test_settled_rti_is_the_solution_of_the_whole_program(sample: int, fly) -> None:
    # The states come from the flight; jumps of the reference lie just ahead of samples 194, 478, 805, 1325 and 1879.
    flight = fly("paper_calibrated")
    scenario = flight.scenario
    x0 = state_at(flight, sample)
    model, reference, guess = model_of(scenario), reference_at(scenario, sample), hover_from(scenario, x0)
    settled = solve_to_convergence(
        make_solver(model, scenario.airframe, scenario.mpc), x0, reference, guess, change=1e-6
    )
    whole = WholeProgram(model, scenario.airframe, scenario.mpc).solve(x0, reference, guess)
    assert settled.plan is not None
    assert whole.plan is not None
    assert np.abs(settled.plan.input[0] - whole.plan.input[0]).max() <= 1e-4 * ROTOR_RANGE


@pytest.mark.parametrize("solver", ["piqp", "osqp"])
@pytest.mark.parametrize("sample", [0, 100, 194, 478, 1325])
def test_qp_accuracy(sample: int, solver: str, fly) -> None:
    # A few samples for each solver; tests/benchmark/test_benchmark.py goes through whole missions.
    flight = fly("paper_calibrated")
    scenario = flight.scenario
    x0 = state_at(flight, sample)
    scenario = scenario.with_overrides([f"mpc.solver={solver}"])
    exact = scenario.with_overrides(["mpc.solver=osqp", "mpc.qp_tolerance=1e-9", "mpc.qp_max_iterations=100000"])
    plans = [
        make_solver(model_of(s), s.airframe, s.mpc).solve(x0, reference_at(s, sample), hover_from(s, x0)).plan
        for s in (scenario, exact)
    ]
    assert plans[0] is not None
    assert plans[1] is not None
    assert np.abs(plans[0].input[0] - plans[1].input[0]).max() <= 1e-4 * ROTOR_RANGE
