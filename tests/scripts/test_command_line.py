import dataclasses
import json
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, FlightEnded, FlightInterrupted, Scenario, run_flight
from a2s_drake.flight.log import array_names
from a2s_drake.study.robustness import DISTURBANCES
from diagrams import build_link_only
from scripts import compare, flying, reproduce, robustness, simulate
from tests.study.test_reproduction import made_up
from tests.support.flights import made_up_flight

SHORT = ["--duration", "0.2", "--set", "mpc.horizon=8"]


def test_simulate_writes_the_contract(tmp_path: Path, capsys) -> None:
    assert simulate.main(["paper_calibrated", *SHORT, "--law", "pitch_only", "--out", str(tmp_path)]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["flight.npz", "metrics.json", "scenario.yaml"]
    with np.load(tmp_path / "flight.npz") as archive:
        assert set(archive) >= {
            *("time", "position", "attitude", "velocity", "angular_velocity", "rotor_speed"),
            *("position_reference", "attitude_reference", "ship_position"),
            *("channel_gain", "snr_db", "spectral_efficiency", "phase_difference"),
            *("solver_success", "solver_iterations"),
        }
        assert archive["rotor_speed"].shape == (11, 6)
    metrics = json.loads((tmp_path / "metrics.json").read_text())
    assert metrics["law"] == "pitch_only"
    assert set(metrics) >= {
        *("law", "throughput_bit_per_hz", "outage", "position_error_max_m", "position_error_rms_m"),
        *("attitude_error_rms_deg", "bounds", "solver", "wall_s", "real_time_factor", "versions"),
    }
    assert set(metrics["solver"]) >= {"failures", "fallbacks", "iterations", "step_ms"}
    printed = capsys.readouterr()
    assert "pitch_only: " in printed.out
    assert printed.err == ""  # no progress bar where there is no terminal


def test_simulate_from_its_own_scenario_gives_the_same_flight(tmp_path: Path) -> None:
    assert simulate.main(["tilt35", *SHORT, "--out", str(tmp_path / "first")]) == 0
    assert simulate.main([str(tmp_path / "first" / "scenario.yaml"), "--out", str(tmp_path / "second")]) == 0
    first, second = (Flight.load(tmp_path / name) for name in ("first", "second"))
    assert first.scenario == second.scenario
    for name in array_names():
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_simulate_writes_a_table_when_asked(tmp_path: Path) -> None:
    assert simulate.main(["paper", *SHORT, "--csv", "--out", str(tmp_path)]) == 0
    header, *rows = (tmp_path / "flight.csv").read_text().splitlines()
    assert header == ",".join(Flight.load(tmp_path).columns())
    assert len(rows) == 11


def test_simulate_takes_overrides_in_order_and_in_groups(tmp_path: Path) -> None:
    overrides = ["--set", "mpc.horizon=20", "link.carrier_hz=5e8", "--set", "mpc.horizon=8"]
    assert simulate.main(["hover", "--duration", "0.1", *overrides, "--out", str(tmp_path)]) == 0
    scenario = Flight.load(tmp_path).scenario
    assert (scenario.mpc.horizon, scenario.link.carrier_hz) == (8, 5e8)


@pytest.mark.parametrize("script", [simulate, compare])
@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["papper"], "no scenario named 'papper'"),
        (["nowhere.yaml"], "nowhere.yaml: No such file or directory"),
        (["pyproject.toml"], "pyproject.toml: a scenario file ends in .yaml or .yml"),
        (["paper", "--law"], "--law"),
        (["paper", "--fast"], "--fast"),
        (["paper", "--set", "airframe.mass=-1"], "airframe.mass = -1.0: must be finite, at least 0.001"),
        (["paper", "--set", "mass=1"], "mass: no such section"),
        (["paper", "--duration", "soon"], "invalid float value: 'soon'"),
        (["paper", "--duration", "-3"], "simulation.duration = -3.0"),
        (["paper", "--set", "mission.sea_level=-24"], "attitude_law.index_max = 50"),
    ],
)
def test_bad_input_prints_one_line_and_writes_nothing(script, arguments, reason, refuses) -> None:
    refuses(script, arguments, reason)


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--jobs", "0"], "--jobs 0: must be at least 1"),
        (["--set", "attitude_law.name=level"], "this script chooses the laws"),
    ],
)
def test_compare_refuses_what_it_would_ignore(arguments: list[str], reason: str, tmp_path: Path, capsys) -> None:
    assert compare.main(["paper", *arguments, "--out", str(tmp_path / "out")]) == 2
    assert reason in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_an_empty_folder_name_is_refused(capsys) -> None:
    assert simulate.main(["paper", "--out", ""]) == 2
    assert "must name a folder" in capsys.readouterr().err


def test_a_reader_that_leaves_is_no_error(tmp_path: Path) -> None:
    command = (
        f"{sys.executable} scripts/simulate.py paper --duration 0.1 --out {tmp_path} | true; exit ${{PIPESTATUS[0]}}"
    )
    process = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert (process.returncode, process.stderr) == (0, "")
    assert (tmp_path / "metrics.json").exists()


@pytest.mark.parametrize(("script", "scenario"), [(simulate, ["paper"]), (compare, ["paper"]), (reproduce, [])])
def test_a_folder_that_cannot_be_made_is_refused_before_the_flight(script, scenario, tmp_path: Path, capsys) -> None:
    (tmp_path / "file").write_text("in the way")
    assert script.main([*scenario, "--out", str(tmp_path / "file")]) == 2
    assert "cannot be made" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("ended", "code"),
    [(FlightEnded("it broke", made_up_flight()), 1), (FlightInterrupted("stopped", made_up_flight()), 130)],
)
def test_a_flight_that_ends_early_keeps_its_log(ended, code: int, tmp_path: Path, capsys, monkeypatch) -> None:
    def end(*_: object, **__: object) -> None:
        raise ended

    monkeypatch.setattr(flying, "fly", end)
    assert simulate.main(["paper", "--out", str(tmp_path)]) == code
    assert len(Flight.load(tmp_path).time) == 5
    assert str(ended) in capsys.readouterr().err


def test_compare_flies_three_laws_and_draws_two_pictures(tmp_path: Path, capsys) -> None:
    assert compare.main(["paper_calibrated", *SHORT, "--out", str(tmp_path)]) == 0
    for law in ("three_axis", "pitch_only", "level"):
        assert Flight.load(tmp_path / law).scenario.attitude_law.name == law
    for picture in ("channel_gain.png", "attitude.png"):
        assert (tmp_path / picture).read_bytes().startswith(b"\x89PNG")
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[3:6]] == ["three_axis", "pitch_only", "level"]


def test_compare_flies_a_scenarios_own_law_too(tmp_path: Path, capsys) -> None:
    small = ["mission.duration=3.0", "mission.radius=0.05", "planning.ipopt_iterations=0"]
    assert compare.main(["planned", "--set", *small, "--duration", "0.2", "--out", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[3:7]] == ["three_axis", "pitch_only", "level", "planned"]
    assert Flight.load(tmp_path / "planned").scenario.attitude_law.name == "planned"


def test_an_early_end_can_leave_a_worker_process() -> None:
    ended = pickle.loads(pickle.dumps(FlightInterrupted("stopped", made_up_flight())))
    assert str(ended) == "stopped"
    assert len(ended.flight.time) == 5


@pytest.fixture
def reproducing(monkeypatch):
    """Reproduces with made-up flights, in threads; the list says what was flown."""
    flown: list[str] = []

    def fly(scenario: Scenario, _place: int) -> Flight:
        flown.append(scenario.attitude_law.name)
        flight = next(iter(made_up({"flight": scenario}).values()))
        n = len(scenario.sample_times())
        arrays = {
            name: np.resize(getattr(flight, name), (n, *getattr(flight, name).shape[1:])) for name in array_names()
        }
        return dataclasses.replace(flight, **arrays | {"time": scenario.sample_times()})

    monkeypatch.setattr(flying, "fly_quietly", fly)
    monkeypatch.setattr(flying, "worker_processes", ThreadPoolExecutor)
    return flown


def test_reproduce_writes_report_results_and_figures(reproducing: list[str], tmp_path: Path, capsys) -> None:
    assert reproduce.main(["--quick", "--out", str(tmp_path)]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["figures", "flights", "report.html", "results.json"]
    assert sorted(reproducing) == ["level", "pitch_only", "three_axis"]
    names = {p.stem for p in (tmp_path / "figures").iterdir()}
    assert {p.name for p in (tmp_path / "figures").iterdir()} == {
        f"{n}.{kind}" for n in names for kind in ("png", "svg")
    }
    results = json.loads((tmp_path / "results.json").read_text())
    assert results["headline"]["gain_percent"]["over_level"] == pytest.approx(50.0)
    printed = capsys.readouterr()
    assert "three axes over level +50.00 %" in printed.out
    assert printed.err == ""


def test_reproduce_writes_a_replay_of_the_headline_flight_where_asked(
    reproducing: list[str], tmp_path: Path, capsys
) -> None:
    assert reproduce.main(["--quick", "--replay", "--out", str(tmp_path)]) == 0
    assert len(reproducing) == 3
    assert "<title>a2s_drake: three_axis, 40 s</title>" in (tmp_path / "replay.html").read_text()
    assert "results.json, replay.html and figures" in capsys.readouterr().out


def test_a_second_reproduction_flies_nothing_and_says_the_same(reproducing: list[str], tmp_path: Path) -> None:
    assert reproduce.main(["--quick", "--out", str(tmp_path)]) == 0
    kept = {name: (tmp_path / name).read_bytes() for name in ("report.html", "results.json", "figures/outage.svg")}
    reproducing.clear()
    assert reproduce.main(["--quick", "--out", str(tmp_path)]) == 0
    assert reproducing == []
    assert {name: (tmp_path / name).read_bytes() for name in kept} == kept


@pytest.mark.usefixtures("reproducing")
def test_reproduce_without_a_replay_still_reports(tmp_path: Path, monkeypatch, capsys) -> None:
    def refuse(*_: object) -> None:
        raise OSError("no Meshcat")

    (tmp_path / "replay.html").write_text("of an earlier flight")
    monkeypatch.setattr(reproduce, "write_replay", refuse)
    assert reproduce.main(["--quick", "--replay", "--out", str(tmp_path)]) == 1
    assert capsys.readouterr().err == f"error: no Meshcat; the report is in {tmp_path}\n"
    assert (tmp_path / "report.html").exists()
    assert not (tmp_path / "replay.html").exists()


def test_a_folder_holds_files_of_one_flight_alone(tmp_path: Path) -> None:
    flying.write_results(made_up_flight(), tmp_path, csv=True)
    assert {path.name for path in tmp_path.iterdir()} == {"scenario.yaml", "flight.npz", "metrics.json", "flight.csv"}
    empty = {name: getattr(made_up_flight(), name)[:0] for name in array_names()}
    flying.write_results(made_up_flight(**empty), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"scenario.yaml", "flight.npz"}


def test_reproduce_flies_a_damaged_flight_again_and_names_it(reproducing: list[str], tmp_path: Path, capsys) -> None:
    assert reproduce.main(["--quick", "--out", str(tmp_path)]) == 0
    damaged = next((tmp_path / "flights").glob("*/flight.npz"))
    damaged.write_bytes(b"damaged")
    reproducing.clear()
    capsys.readouterr()
    assert reproduce.main(["--quick", "--out", str(tmp_path)]) == 0
    assert len(reproducing) == 1
    assert f"warning: a kept flight is damaged and is flown again: {damaged}" in capsys.readouterr().err


def test_an_interrupted_reproduction_keeps_its_flights(
    reproducing: list[str], tmp_path: Path, monkeypatch, capsys
) -> None:
    fly, calls = flying.fly_quietly, []

    def interrupted(scenario: Scenario, place: int) -> Flight:
        calls.append(place)
        if place == 2:
            raise KeyboardInterrupt
        return fly(scenario, place)

    monkeypatch.setattr(flying, "fly_quietly", interrupted)
    assert reproduce.main(["--quick", "--jobs", "1", "--out", str(tmp_path)]) == 130
    assert "interrupted; flights done are kept" in capsys.readouterr().err
    kept = list((tmp_path / "flights").iterdir())
    assert len(kept) == 2
    assert all(len(Flight.load(place).time) == 2001 for place in kept)
    monkeypatch.setattr(flying, "fly_quietly", fly)
    reproducing.clear()
    assert reproduce.main(["--quick", "--out", str(tmp_path)]) == 0
    assert len(reproducing) == 1


@pytest.mark.parametrize("script", ["simulate", "compare", "reproduce"])
def test_scripts_stay_short(script: str) -> None:
    assert len(Path(f"scripts/{script}.py").read_text().splitlines()) <= 60


def test_robustness_prints_the_table_and_says_where_it_is(tmp_path: Path, monkeypatch, capsys) -> None:
    flown: list[str] = []

    def fly(scenario: Scenario, _place: int) -> Flight:
        flown.append(scenario.to_yaml())
        return run_flight(build_link_only(scenario), scenario)

    monkeypatch.setattr(flying, "fly_quietly", fly)
    monkeypatch.setattr(flying, "worker_processes", ThreadPoolExecutor)
    assert robustness.main(["--duration", "0.1", "--jobs", "1", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert (tmp_path / "robustness.md").read_text() in printed + "\n"
    assert f"are in {tmp_path}" in printed
    assert len(flown) == 2 * len(DISTURBANCES)


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--set", "attitude_law.name=level"], "this script chooses the laws"),
        (["--set", "disturbance.mass_factor=2"], "this script chooses the disturbances"),
        (["--jobs", "0"], "--jobs 0: must be at least 1"),
        (["papper"], "no scenario named"),
    ],
)
def test_robustness_refuses_in_one_line(arguments: list[str], reason: str, refuses) -> None:
    refuses(robustness, arguments, reason)
