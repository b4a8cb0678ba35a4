"""Each example runs, draws its picture, and prints what an oracle of its own confirms."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Airframe, Scenario, compute_metrics, run_flight, wrench_map
from diagrams import build_closed_loop
from scripts import examples
from scripts.examples import (
    channel_map,
    fed_law,
    figure_eight,
    linearise_airframe,
    one_mpc_step,
    own_airframe,
    own_law,
    turning_ship,
)

FOLDER = Path(examples.__file__).parent
NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"


@pytest.fixture
def show(tmp_path: Path, capsys) -> Callable[..., str]:
    """Runs an example, checks its picture, and returns what it printed."""

    def run(example, *arguments: str) -> str:
        name = example.__name__.rpartition(".")[2]
        assert example.main([*arguments, "--out", str(tmp_path)]) == 0
        assert sorted(path.name for path in tmp_path.iterdir()) == [f"{name}.png", f"{name}.svg"]
        assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        printed = capsys.readouterr()
        assert printed.err == ""
        return printed.out

    return run


def numbers(text: str, before: str) -> list[float]:
    """The numbers in the line that starts with a text, behind that text."""
    (line,) = (line for line in text.splitlines() if line.startswith(before))
    return [float(number) for number in re.findall(NUMBER, line.removeprefix(before))]


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.py")), ids=lambda path: path.name)
def test_every_example_stays_short_enough_to_read(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 60


def test_the_channel_map_meets_the_blueprint_at_level_and_at_the_laws_answer(show) -> None:
    printed = show(channel_map)
    assert "level, [0. 0. 0.] deg: |g|^2 = 1.199032629e-08" in printed
    assert "[-9.83  8.73  2.2 ] deg: |g|^2 = 2.412125015e-08" in printed


def test_a_free_body_is_chains_of_integrators_all_but_the_quaternions_norm_controllable(show) -> None:
    printed = show(linearise_airframe)
    # A quaternion is half the angle: lean by it and 2 g act across; turn at 1 rad/s, and across goes a jerk of g.
    *chain, fourth = numbers(printed, "largest entry of A, A^2, A^3, A^4:")
    assert chain == pytest.approx([2.0 * 9.81, 2.0 * 9.81, 9.81], rel=0.03)
    assert fourth < 1e-9
    assert numbers(printed, "largest |eigenvalue| as computed:")[0] < 1e-3
    assert "controllable: 12 of the plant's 13 states, 12 of the 12" in printed
    assert max(numbers(printed, "off the MPC's prediction model:")) < 1e-9


def test_one_step_of_the_mpc_pays_what_its_terms_add_up_to(show) -> None:
    printed = show(one_mpc_step)
    names = ("position", "attitude", "velocity", "angular_velocity", "input")
    cost, share = np.transpose([numbers(printed, f"{name} ") for name in names])
    added, stated = numbers(printed, "sum")
    assert added == pytest.approx(stated, abs=2e-3)
    assert cost.sum() == pytest.approx(stated, abs=5e-3)
    assert share.sum() == pytest.approx(100.0, abs=0.3)
    # 30 cm off, the vehicle wants back at once, more than its rotors give.
    assert "rotor_1 on its upper bound in period" in printed


def test_a_law_of_ones_own_beats_level_and_strays_less_than_the_papers(show) -> None:
    printed = show(own_law, "--duration", "6.5")
    won, astray = np.transpose([numbers(printed, f"{name}:") for name in ("level", "the paper's law", "own law")])
    assert won[2] > 1.1 * won[0]
    assert astray[2] < 0.5 * astray[1]
    # Level, the vehicle only keeps the 1.4 cm of height that the paper's cost on the input asks for.
    assert astray[0] == pytest.approx(0.014, abs=0.002)


def test_fed_level_flies_where_it_should_and_the_papers_law_wins_what_it_did(show) -> None:
    fed = show(fed_law, "--duration", "3")
    won, astray = np.transpose([numbers(fed, f"{name}:") for name in ("level", "the paper's law")])
    assert astray[0] < 0.001 < astray[1]
    papers = Scenario().with_value("simulation.duration", 3.0)
    unfed = compute_metrics(run_flight(build_closed_loop(papers), papers))
    assert won[1] == pytest.approx(unfed["throughput_bit_per_hz"], rel=0.01)
    assert astray[1] < unfed["position_error_max_m"]


def test_on_a_figure_eight_the_papers_law_beats_level(show) -> None:
    printed = show(figure_eight, "--duration", "20")
    won, astray = np.transpose([numbers(printed, f"{name}:") for name in ("level", "the paper's law")])
    assert won[1] > 1.2 * won[0]
    assert astray[1] < 0.2


def test_a_path_that_is_too_fast_is_refused_in_one_line(tmp_path: Path, capsys) -> None:
    assert figure_eight.main(["--duration", "10", "--out", str(tmp_path)]) == 2
    printed = capsys.readouterr()
    # Twice pi^2 / T times the half length of 2 m, on the x axis.
    assert re.search(r"mission.path_file = .*figure_eight.csv': reaches 1.97\d? m/s on an axis at t = 5 s", printed.err)
    assert printed.err.count("\n") == 1


def test_to_a_ship_that_turns_back_the_papers_law_beats_level(show) -> None:
    # At 2 m/s it has turned after 10 s straight ahead and half a circle of 10 m, 25.7 s in all.
    printed = show(turning_ship, "--speed", "2", "--duration", "27")
    won, _ = np.transpose([numbers(printed, f"{name}:") for name in ("level", "the paper's law")])
    assert won[1] > 1.1 * won[0]
    assert numbers(printed, "ship: heads for") == [0.0, 180.0]


def test_a_bad_duration_is_refused_in_one_line(tmp_path: Path, capsys) -> None:
    assert own_law.main(["--duration", "-1", "--out", str(tmp_path)]) == 2
    printed = capsys.readouterr()
    assert "simulation.duration = -1.0" in printed.err
    assert printed.err.count("\n") == 1
    assert printed.out == ""
    assert list(tmp_path.iterdir()) == []


def hover_pitch_deg(airframe: Airframe) -> float:
    """The largest pitch at which least squares finds rotor speeds within bounds that carry the vehicle, deg."""
    low, high = airframe.rotor_speed_min**2, airframe.rotor_speed_max**2
    for pitch in np.arange(0.0, 45.0, 0.01):
        up_B = np.array([-np.sin(np.deg2rad(pitch)), 0.0, np.cos(np.deg2rad(pitch))])
        wrench = np.concatenate([airframe.mass * 9.81 * up_B, np.zeros(3)])
        u = np.linalg.lstsq(wrench_map(airframe), wrench, rcond=None)[0]
        if u.min() < low or u.max() > high:
            return float(pitch)
    return 45.0


def test_pitch_ends_at_eleven_degrees_for_table_i_and_grows_with_tilt(show) -> None:
    printed = show(own_airframe)
    for tilt in (10.0, 20.0, 30.0, 40.0):
        pitch = numbers(printed, f"tilt {tilt:g} deg:")[2]
        assert pitch == pytest.approx(hover_pitch_deg(Airframe(tilt_deg=tilt)), abs=0.1)
    assert numbers(printed, "tilt 20 deg:")[2] == pytest.approx(11.0, abs=0.2)
    assert "tilt 40 deg: " in printed
    assert "100 % of the controller's box" in printed


def test_a_changed_airframe_reaches_further_without_its_lower_bound(show) -> None:
    printed = show(own_airframe, "--change", "airframe.rotor_speed_min=0")
    expected = hover_pitch_deg(Airframe(rotor_speed_min=0.0))
    assert numbers(printed, "tilt 20 deg:")[2] == pytest.approx(expected, abs=0.1)
    assert 11.5 < expected < 12.5
