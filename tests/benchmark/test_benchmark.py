"""The benchmark: what it records, times and compares. How fast the machine is, no quick test says."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Scenario, ScenarioError
from a2s_drake.benchmark.accuracy import deviation_percent, exact_inputs
from a2s_drake.benchmark.contestants import Conic, Own, Plain, Run, Whole
from a2s_drake.benchmark.growth import HORIZONS, fit_growth, growth_figure
from a2s_drake.benchmark.plain import PlainOsqp
from a2s_drake.benchmark.record import TrackingProblem, record
from a2s_drake.benchmark.suite import Benchmark
from a2s_drake.benchmark.summary import peak_memory_mib
from a2s_drake.benchmark.timing import runs_in_a_row, spread, statistics_ms, time_interleaved
from a2s_drake.control.program import input_bounds
from a2s_drake.control.solve import make_solver
from a2s_drake.flight.log import array_names
from diagrams import load_scenario
from scripts import benchmark
from tests.support.tracking import ROTOR_RANGE, model_of

DURATION = "simulation.duration=0.6"

Recorded = tuple[Flight, list[TrackingProblem]]


@pytest.fixture(scope="module")
def recorded() -> Recorded:
    """The first 31 samples of the mission, and its problems."""
    return record(load_scenario("paper_calibrated").with_overrides([DURATION]).validate())


def test_recording_changes_nothing_in_the_flight(recorded: Recorded, fly) -> None:
    expected = fly("paper_calibrated", DURATION)
    for name in array_names():
        np.testing.assert_array_equal(getattr(recorded[0], name), getattr(expected, name))


def test_recorded_problems_replay_to_the_flights_own_inputs(recorded: Recorded) -> None:
    flight, problems = recorded
    scenario, samples = flight.scenario, len(flight.time)
    assert samples < len(problems) <= samples + 9  # The cold start poses up to ten.
    dut = Own(scenario.airframe, scenario.mpc)
    inputs = [dut.run(problem).input for problem in problems[-samples:]]
    applied = np.sqrt(np.clip(inputs, *input_bounds(scenario.airframe)))
    np.testing.assert_allclose(applied, flight.rotor_speed, rtol=1e-12)


def test_problems_are_those_at_the_measured_states(recorded: Recorded) -> None:
    flight, problems = recorded
    states = np.hstack([flight.position, flight.attitude, flight.velocity, flight.angular_velocity])
    np.testing.assert_array_equal([problem.x0 for problem in problems[-len(states) :]], states)
    assert problems[-1].reference.position.shape == (31, 3)


def test_parts_of_a_step_add_up_to_it(recorded: Recorded) -> None:
    scenario, problems = recorded[0].scenario, recorded[1]
    timing = time_interleaved(problems, {"own": Own(scenario.airframe, scenario.mpc)})["own"]
    assert list(timing.parts) == ["linearise", "update", "solve", "read_back"]
    assert all((part > 0.0).all() for part in timing.parts.values())
    np.testing.assert_allclose(sum(timing.parts.values()), timing.total)
    assert timing.failures == 0
    assert (timing.iterations > 0).all()


@pytest.mark.parametrize("solver", ["piqp", "osqp"])
def test_applied_inputs_are_accurate(solver: str, recorded: Recorded) -> None:
    scenario, problems = recorded[0].scenario.with_overrides([f"mpc.solver={solver}"]), recorded[1][::4]
    timing = time_interleaved(problems, {"own": Own(scenario.airframe, scenario.mpc)})["own"]
    exact = exact_inputs(problems, scenario.airframe, scenario.mpc)
    deviation = deviation_percent(timing.input, exact, scenario.airframe)
    assert deviation is not None
    assert 0.0 < deviation <= 0.1  # An exact zero would say that the oracle is the solver itself.


def test_deviation_is_that_of_the_clipped_input_in_percent_of_the_range(scenario: Scenario) -> None:
    exact = np.full((3, 6), 5000.0)
    inputs = exact.copy()
    inputs[0, 2] += 0.01 * ROTOR_RANGE
    exact[1, 5], inputs[1, 5] = 1e4, 2e4  # Both are applied as the largest there is.
    inputs[2] = np.nan
    assert deviation_percent(inputs, exact, scenario.airframe) == pytest.approx(1.0)
    assert deviation_percent(inputs[2:], exact[2:], scenario.airframe) is None


def test_a_flight_without_a_problem_ends_with_a_line(tmp_path: Path, capsys) -> None:
    # Measured far beyond the bounds, no state reaches a solver.
    overrides = ["--set", "disturbance.velocity_noise=1e3"]
    assert benchmark.main(["--duration", "0.1", "--no-peers", *overrides, "--out", str(tmp_path)]) == 1
    assert "posed no problem" in capsys.readouterr().err


def test_the_plain_baseline_solves_the_same_qp(recorded: Recorded) -> None:
    scenario = recorded[0].scenario.with_overrides(["mpc.solver=osqp"])
    expected = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
    dut = PlainOsqp(model_of(scenario), scenario.airframe, scenario.mpc)
    for problem in recorded[1][::5]:
        mine, theirs = (solver.solve(problem.x0, problem.reference, problem.guess).plan for solver in (dut, expected))
        assert mine is not None
        assert theirs is not None
        np.testing.assert_allclose(mine.input[0], theirs.input[0], atol=1e-4 * ROTOR_RANGE)
        np.testing.assert_allclose(mine.state, theirs.state, atol=1e-4)


def test_the_plain_baseline_says_when_there_is_no_solution(recorded: Recorded) -> None:
    flight, problems = recorded
    x0 = problems[0].x0.copy()
    x0[6:9] = 50.0  # far beyond the bound on speed
    problem = TrackingProblem(x0, problems[0].reference, problems[0].guess)
    run = Plain(flight.scenario.airframe, flight.scenario.mpc).run(problem)
    assert np.isnan(run.input).all()


def test_casadis_solvers_solve_recorded_problems(recorded: Recorded) -> None:
    pytest.importorskip("casadi", reason="CasADi's solvers need the package casadi: pip install 'a2s_drake[bench]'")
    scenario, problems = recorded[0].scenario, recorded[1][-3:]
    airframe, mpc = scenario.airframe, scenario.mpc
    exact = exact_inputs(problems, airframe, mpc)
    timings = time_interleaved(problems, {"hpipm": Conic("hpipm", airframe, mpc), "ipopt": Whole(airframe, mpc)})
    assert list(timings["hpipm"].parts) == ["solve"]
    assert deviation_percent(timings["hpipm"].input, exact, airframe) <= 0.01
    assert deviation_percent(timings["ipopt"].input, exact, airframe) <= 5.0  # the nonlinear program's own solution


class Counting:
    """A contestant that logs what it is given."""

    def __init__(self, name: str, log: list[tuple[str, int]]) -> None:
        self._name, self._log = name, log

    def run(self, problem: int) -> Run:
        self._log.append((self._name, problem))
        return Run({"solve": float(problem)}, np.full(6, np.nan if problem == 4 else problem), np.nan)


def test_contestants_take_turns_and_some_sit_out() -> None:
    log: list[tuple[str, int]] = []
    duts = {name: Counting(name, log) for name in ("a", "b")}
    timings = time_interleaved(range(6), duts, {"b": np.array([0, 4])}, turn=2)
    assert log[:2] == [("a", 0), ("b", 0)]  # untimed
    assert log[2:] == [("a", 0), ("a", 1), ("b", 0), ("a", 2), ("a", 3), ("a", 4), ("a", 5), ("b", 4)]
    assert timings["b"].total.tolist() == [0.0, 4.0]
    assert timings["a"].at(timings["b"].places).total.tolist() == [0.0, 4.0]
    assert (timings["a"].failures, timings["b"].failures) == (1, 1)


def test_casadis_solvers_get_an_even_share() -> None:
    assert spread(100, 20, 99).tolist() == [0, 20, 40, 60, 80]
    assert spread(2001, 20, 20).tolist() == list(range(0, 2001, 120))
    assert runs_in_a_row(100, 3, 2).tolist() == [0, 1, 49, 50, 98, 99]
    assert runs_in_a_row(3, 4, 5).tolist() == [0, 1, 2]


def test_statistics_are_in_milliseconds() -> None:
    statistics = statistics_ms(np.arange(1001.0) / 1e3)
    expected = {"median": 500.0, "p99": 990.0, "p99_9": 999.0, "max": 1000.0}
    assert dataclasses.asdict(statistics) == pytest.approx(expected)


def test_growth_finds_the_line_and_the_power() -> None:
    line = fit_growth(HORIZONS, 0.5 + 0.04 * np.array(HORIZONS), np.full(5, 7.0))
    assert (line.offset_ms, line.per_stage_ms, line.r_squared) == pytest.approx((0.5, 0.04, 1.0))
    square = fit_growth(HORIZONS, 1e-3 * np.array(HORIZONS) ** 2.0, np.full(5, 7.0))
    assert square.exponent == pytest.approx(2.0)
    assert square.r_squared < 0.96
    (axes,) = growth_figure({"piqp": line, "osqp": square}).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("horizon $N$", "median step time (ms)")
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), line.median_ms)


def test_peak_memory_is_in_mebibytes() -> None:
    assert 50.0 < peak_memory_mib() < 1e5


def test_a_solver_of_the_whole_program_is_refused(scenario: Scenario) -> None:
    scenario.mpc.solver = "ipopt"
    with pytest.raises(ScenarioError, match="the benchmark times piqp, osqp"):
        Benchmark(scenario, 0).check()


def test_script_writes_the_numbers(tmp_path: Path, capsys) -> None:
    file = tmp_path / "numbers.json"
    assert benchmark.main(["--duration", "0.4", "--no-peers", "--json", str(file), "--out", str(tmp_path / "out")]) == 0
    numbers = json.loads(file.read_text())
    for times in (numbers["step_ms"], *numbers["split_ms"].values(), numbers["plain"]["step_ms"]):
        assert 0.0 < times["median"] <= times["p99"] <= times["p99_9"] <= times["max"]
    assert set(numbers["split_ms"]) == {"linearise", "update", "solve", "read_back"}
    assert set(numbers["iterations"]) == {"median", "max"}
    assert 0.0 < numbers["accuracy_percent"] <= 0.1
    assert numbers["without_exact_solution"] == numbers["failures"] == 0
    assert numbers["step_over_plain"] > 0.0
    assert numbers["flight"]["real_time_factor"] > 0.0
    assert numbers["peak_memory_mib"]["flight"] <= numbers["peak_memory_mib"]["benchmark"]
    assert numbers["peers"] == {}
    assert set(numbers["growth"]) == {"piqp", "osqp"}
    assert numbers["growth"]["piqp"]["horizons"] == [10, 20, 30, 60, 120]
    assert (tmp_path / "out/growth.png").read_bytes().startswith(b"\x89PNG")
    printed = capsys.readouterr()
    assert "times plain Drake + OSQP" in printed.out
    assert printed.err == ""


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["papper"], "no scenario named 'papper'"),
        (["--peers-every", "0"], "--peers-every 0: must be at least 1"),
        (["--set", "mpc.solver=ipopt"], "mpc.solver = ipopt"),
        (["--json", "pyproject.toml/a.json"], "--json pyproject.toml/a.json: its folder cannot be made"),
        (["--json", "scripts"], "--json scripts: cannot be written"),
        (["--fast"], "--fast"),
    ],
)
def test_bad_input_prints_one_line(arguments: list[str], reason: str, refuses) -> None:
    refuses(benchmark, arguments, reason)


def test_an_interrupt_ends_it(tmp_path: Path, monkeypatch, capsys) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Benchmark, "run", interrupt)
    assert benchmark.main(["--out", str(tmp_path)]) == 130
    assert capsys.readouterr().err == "error: interrupted\n"


def test_script_stays_short() -> None:
    assert len(Path("scripts/benchmark.py").read_text().splitlines()) <= 60


@pytest.mark.slow  # a reading of the machine, so not in the default suite
def test_a_step_takes_at_most_0_42_of_plain_drakes() -> None:
    scenario = load_scenario("paper_calibrated").with_overrides(["simulation.duration=4"]).validate()
    airframe, mpc = scenario.airframe, scenario.mpc
    _, problems = record(scenario)
    timings = time_interleaved(problems, {"own": Own(airframe, mpc), "plain": Plain(airframe, mpc)})
    assert np.median(timings["own"].total) <= 0.42 * np.median(timings["plain"].total)
    assert deviation_percent(timings["own"].input, exact_inputs(problems, airframe, mpc), airframe) <= 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "law"), [("paper_calibrated", "three_axis"), ("paper", "three_axis"), ("paper", "pitch_only")]
)
def test_every_step_of_the_mission_is_within_a_tenth_of_a_percent_of_the_exact_solution(name: str, law: str) -> None:
    scenario = load_scenario(name).with_overrides([f"attitude_law.name={law}"]).validate()
    airframe, mpc = scenario.airframe, scenario.mpc
    _, problems = record(scenario)
    exact = exact_inputs(problems, airframe, mpc)
    own = Own(airframe, mpc)
    applied = np.array([own.run(problem).input for problem in problems])
    assert len(problems) >= 2001
    assert np.isfinite(exact).all()
    assert deviation_percent(applied, exact, airframe) <= 0.1
