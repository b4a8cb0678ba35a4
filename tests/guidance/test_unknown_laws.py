"""Names that the soft-min does not know are refused, and never flown as another law."""

import re

import numpy as np
import pytest

from a2s_drake import AttitudeLaw, AttitudeReference, Link, Scenario, ScenarioError, attitude_reference
from a2s_drake.guidance import laws
from a2s_drake.scenario import parts

KNOWN = {"name": "three_axis, pitch_only, level", "fallback": "nearest, zero, index_zero"}
BOX = np.deg2rad(15.0)


def refusal(field: str, value: str) -> str:
    return "^" + re.escape(f"attitude_law.{field} = {value!r}: must be one of {KNOWN[field]}") + "$"


@pytest.mark.parametrize(("field", "value"), [("name", "locked"), ("name", ""), ("fallback", "neerest")])
def test_an_unknown_name_is_refused_along_a_geometry_and_by_the_block(field: str, value: str) -> None:
    law = AttitudeLaw(**{field: value})
    with pytest.raises(ScenarioError, match=refusal(field, value)):
        attitude_reference(np.zeros(3), np.array([90.0, 0.0, -20.0]), Link(), law, BOX)
    with pytest.raises(ScenarioError, match=refusal(field, value)):
        AttitudeReference(Link(), law, BOX, 1)


def test_a_plan_is_no_law_of_the_soft_min() -> None:
    with pytest.raises(ScenarioError, match=r"^attitude_law\.name = 'planned': a plan depends on time"):
        AttitudeReference(Link(), AttitudeLaw(name="planned"), BOX, 1)


def test_a_law_that_only_the_scenario_and_the_registry_know_is_refused(
    scenario: Scenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parts, "LAW_NAMES", (*parts.LAW_NAMES, "locked"))
    monkeypatch.setitem(laws.LAWS, "locked", laws.LAWS["three_axis"])
    scenario.attitude_law.name = "locked"
    with pytest.raises(ScenarioError, match=refusal("name", "locked")):
        laws.build_law(scenario)
