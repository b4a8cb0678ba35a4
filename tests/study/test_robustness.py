import re
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Scenario, ScenarioError, run_flight
from a2s_drake.guidance.plan.cache import plan_for_law
from a2s_drake.study.robustness import DISTURBANCES, robustness_scenarios, robustness_table
from diagrams import build_closed_loop, load_scenario
from tests.support.flights import SAMPLES, made_up_flight

TABLE = Path(__file__).parents[2] / "docs" / "robustness.md"


def test_each_disturbance_is_flown_by_both_laws_and_changes_the_disturbance_alone(scenario: Scenario) -> None:
    scenarios = robustness_scenarios(scenario)
    assert len(scenarios) == 2 * len(DISTURBANCES)
    assert len({flown.to_yaml() for flown in scenarios.values()}) == len(scenarios)
    for name, flown in scenarios.items():
        assert flown.attitude_law.name == ("level" if name.endswith("level") else "three_axis")
        flown.attitude_law.name, flown.disturbance = scenario.attitude_law.name, scenario.disturbance
        assert flown == scenario


def test_table_has_a_row_for_each(scenario: Scenario) -> None:
    rates = {"three_axis": 6.0, "level": 5.0}
    flights = {
        name: made_up_flight(law, spectral_efficiency=np.full(SAMPLES, rates[law]))
        for name in robustness_scenarios(scenario)
        for law in [name.rsplit(", ", 1)[1]]
    }
    lines = robustness_table(flights, "three_axis").splitlines()
    assert [line.split(" | ")[0].removeprefix("| ") for line in lines[2:]] == list(DISTURBANCES)
    assert all("+20.0 %" in line and "0.6 bit/Hz" in line for line in lines[2:])


def test_a_scenarios_own_law_is_flown() -> None:
    laws = {scenario.attitude_law.name for scenario in robustness_scenarios(load_scenario("planned")).values()}
    assert laws == {"planned", "level"}
    with pytest.raises(ScenarioError, match=r"attitude_law\.name = 'level': must be another law"):
        robustness_scenarios(load_scenario("hover"))


def documented_rows(law: str) -> dict[str, list[float]]:
    """The numbers of each row of the documentation's table for a law, by disturbance."""
    rows = {}
    papers, planned = TABLE.read_text(encoding="utf-8").split("## Under a plan")
    for line in (planned if law == "planned" else papers).splitlines():
        name, *cells = line.strip("| ").split(" | ")
        if name in DISTURBANCES and cells:
            rows[name] = [float(number) for number in re.findall(r"[-+]?\d+\.?\d*", " ".join(cells))]
    return rows


@pytest.mark.parametrize("law", ["three_axis", "planned"])
def test_documentation_has_the_whole_table(law: str) -> None:
    assert list(documented_rows(law)) == list(DISTURBANCES)


def flown(scenario: str, law: str, disturbance: str) -> tuple[dict[str, Flight], list[float]]:
    """A disturbed flight under a law and under level, and the numbers of their row."""
    scenarios = robustness_scenarios(load_scenario(scenario))
    pair = {
        name: run_flight(build_closed_loop(one, plan=plan_for_law(one)), one)
        for name, one in ((name, scenarios[f"{disturbance}, {name}"]) for name in (law, "level"))
    }
    # The table is drawn for this one row; the others are filled with it.
    table = robustness_table({name: pair[name.rsplit(", ", 1)[1]] for name in scenarios}, law)
    return pair, [float(text) for text in re.findall(r"[-+]?\d+\.?\d*", table.splitlines()[2].split(" | ", 1)[1])]


@pytest.mark.slow
@pytest.mark.parametrize("disturbance", DISTURBANCES)
def test_mission_holds_under_each_disturbance_as_documented(disturbance: str) -> None:
    pair, numbers = flown("paper_calibrated", "three_axis", disturbance)
    # bit/Hz, %, cm and cm to one digit, degrees to two, and no failure: the last digit may round the other way.
    off = np.abs(np.subtract(numbers, documented_rows("three_axis")[disturbance]))
    assert (off <= [0.101, 0.101, 0.101, 0.101, 0.0101, 0.0101, 0.0101, 0.0]).all()
    for flight in pair.values():
        assert flight.solver_success.all()
        assert np.linalg.norm(flight.position - flight.position_reference, axis=1).max() < 0.15


@pytest.mark.slow
@pytest.mark.parametrize("disturbance", ["none", "mass 10 % up", "commands one period late"])
def test_a_planned_mission_holds_as_documented(disturbance: str) -> None:
    _, numbers = flown("planned", "planned", disturbance)
    off = np.abs(np.subtract(numbers, documented_rows("planned")[disturbance]))
    assert (off <= [0.101, 0.101, 0.101, 0.101, 0.0101, 0.0101, 0.0101, 0.0]).all()
