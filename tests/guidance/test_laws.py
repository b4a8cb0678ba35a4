from dataclasses import fields

import pytest

from a2s_drake import AttitudeLaw, PlannedReference, Scenario, ScenarioError
from a2s_drake.guidance import laws
from a2s_drake.guidance.laws import LAWS, build_law, find_law


def test_the_registry_holds_every_name_that_a_scenario_may_have() -> None:
    (name,) = (entry for entry in fields(AttitudeLaw) if entry.name == "name")
    assert tuple(LAWS) == name.metadata["choices"]


@pytest.mark.parametrize("name", ["four_axis", "", "Level"])
def test_an_unknown_law_is_refused_and_never_flown_as_another(name: str, scenario: Scenario) -> None:
    scenario.attitude_law.name = name  # past the checks of a scenario
    with pytest.raises(ScenarioError, match=rf"^attitude_law\.name = '{name}': must be one of three_axis"):
        build_law(scenario)


def test_a_law_known_to_the_registry_alone_gets_its_own_block(
    scenario: Scenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Scenario] = []
    monkeypatch.setitem(LAWS, "mine", laws.Law("mine", {}, lambda s, _: made.append(s)))  # type: ignore[arg-type]
    scenario.attitude_law.name = "mine"
    build_law(scenario)
    assert made == [scenario]


def test_a_law_that_needs_a_plan_says_so(scenario: Scenario) -> None:
    assert [name for name in LAWS if find_law(name).needs_plan] == ["planned"]
    dut = build_law(scenario.with_value("attitude_law.name", "planned"))
    assert isinstance(dut, PlannedReference)
    with pytest.raises(ScenarioError, match="built without a plan"):
        dut.GetOutputPort("attitude_reference").Eval(dut.CreateDefaultContext())
