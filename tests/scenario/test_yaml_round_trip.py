import dataclasses
import re
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from a2s_drake import Scenario

# Drake writes 1e5 without quotes, since YAML 1.1 takes it for a text; no name is written so.
LIKE_A_NUMBER = re.compile(r"[-+.0-9]+[eE][-+0-9]+")
texts = st.text(st.characters(codec="utf-8")).filter(lambda text: not LIKE_A_NUMBER.fullmatch(text))


def values_of(entry: dataclasses.Field) -> st.SearchStrategy[Any]:
    """Every value that a field may have by its declared limits."""
    limits = dict(entry.metadata)
    length = limits.pop("length", None)
    if "choices" in limits:
        return st.sampled_from(limits["choices"])
    if "file" in limits:
        return st.none() | texts
    low, high = limits.get("at_least", limits.get("above")), limits.get("at_most", limits.get("below"))
    if entry.type is int:
        return st.integers(low, high)
    ends = {"exclude_min": "above" in limits, "exclude_max": "below" in limits}
    number = st.floats(low, high, **ends)
    if length is not None:
        return st.lists(number, min_size=length, max_size=length)
    return number if entry.default is not None else st.none() | number


def parts(kind: Any) -> st.SearchStrategy[Any]:
    """Every part of a scenario that its declared limits allow."""
    return st.builds(kind, **{entry.name: values_of(entry) for entry in dataclasses.fields(kind)})


scenarios = st.builds(Scenario, **{part.name: parts(part.default_factory) for part in dataclasses.fields(Scenario)})


@given(scenarios)
def test_the_yaml_of_any_scenario_is_read_back_exactly(dut: Scenario) -> None:
    again = Scenario.from_yaml(dut.to_yaml())
    assert again == dut
    assert repr(again) == repr(dut)  # which tells 1 from 1.0 and 0.0 from -0.0


@pytest.mark.parametrize(
    "number", [1e16, 1e-5, 1e22, 1e300, 5e-324, 1.7976931348623157e308, -0.0, 1 / 3, 0.1 + 0.2, 12345678901234567890.0]
)
def test_oddly_dumped_numbers_are_read_back_exactly(number: float) -> None:
    dut = Scenario()
    dut.mission.radius = dut.simulation.duration = number
    dut.mission.ship_start = dut.mission.ship_end = [number, number]  # one list in two fields
    assert repr(Scenario.from_yaml(dut.to_yaml())) == repr(dut)


@given(texts)
@example("true").via("a word that stands for something else")
@example("null").via("the same")
@example("1:30a: b # c").via("what YAML reads something into")
@example("- a\n\n b\u2028\x85\ufeff'\"").via("breaks, blanks and quotes")
def test_texts_are_read_back_exactly(text: str) -> None:
    dut = Scenario()
    dut.attitude_law.name = text
    assert Scenario.from_yaml(dut.to_yaml()).attitude_law.name == text
