"""Ranges and orders of a scenario's numbers, at their very edges."""

import itertools
from dataclasses import dataclass

import numpy as np
import pytest

from a2s_drake import Airframe, Scenario, ScenarioError
from a2s_drake.scenario.checks import check_inertia, check_order, check_part
from a2s_drake.scenario.parts import _number, _vector


@dataclass
class Part:
    """One field of each kind of limit."""

    above: float = _number(1.0, above=0.0)
    at_least: float = _number(1.0, at_least=0.0)
    below: float = _number(1.0, below=2.0)
    at_most: float = _number(1.0, at_most=2.0)
    entries: list[float] = _vector(1.0, 1.0, at_most=2.0)
    optional: float | None = _number(None, at_least=0.0)


def test_limits_within_a_limit_pass() -> None:
    check_part("part", Part(at_least=0.0, at_most=2.0, entries=[2.0, 2.0], optional=0.0))
    check_part("part", Part(above=float(np.nextafter(0.0, 1.0)), below=float(np.nextafter(2.0, 0.0))))
    check_part("part", Part(optional=None))


@pytest.mark.parametrize(
    ("field", "value", "allowed"),
    [
        ("above", 0.0, "must be finite, above 0.0"),
        ("at_least", -5e-324, "must be finite, at least 0.0"),
        ("below", 2.0, "must be finite, below 2.0"),
        ("at_most", float(np.nextafter(2.0, 3.0)), "must be finite, at most 2.0"),
        ("entries", [2.0, float(np.nextafter(2.0, 3.0))], "must be finite, at most 2.0"),
        ("entries", [2.0], "must have 2 entries, has 1"),
        ("optional", -1.0, "must be finite, at least 0.0"),
        ("above", np.inf, "must be finite, above 0.0"),
        ("at_most", -np.inf, "must be finite, at most 2.0"),
        ("at_least", np.nan, "must be finite, at least 0.0"),
    ],
)
def test_the_smallest_step_beyond_a_limit_is_refused(field: str, value: object, allowed: str) -> None:
    with pytest.raises(ScenarioError) as refusal:
        check_part("part", Part(**{field: value}))
    assert str(refusal.value) == f"part.{field} = {value!r}: {allowed}"


def test_equal_limits_pass_where_the_order_is_not_strict() -> None:
    scenario = Scenario().with_overrides(["attitude_law.index_min=43", "attitude_law.index_max=43"])
    check_order("attitude_law", scenario.attitude_law, "index_min", "index_max", strict=False)
    with pytest.raises(ScenarioError, match=r"attitude_law\.index_min = 43: must be below attitude_law\.index_max"):
        check_order("attitude_law", scenario.attitude_law, "index_min", "index_max")


@pytest.mark.parametrize("moments", [(0.1, 0.2, 0.3), (0.24, 0.69, 0.93), (0.1, 0.7, 0.8), (1e-6, 1e-6, 2e-6)])
def test_a_flat_body_passes_however_its_moments_are_rounded(moments: tuple[float, ...]) -> None:
    for order in itertools.permutations(moments):
        check_inertia(Airframe(inertia=list(order)))


def test_rounding_alone_puts_some_flat_bodies_beyond_the_sum() -> None:
    assert 2.0 * 0.93 > 0.24 + 0.69 + 0.93  # else the test above would show nothing


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize("excess", [1e-9, 1e-3, 1.0])
def test_a_moment_beyond_the_sum_of_the_others_is_refused(place: int, excess: float) -> None:
    moments = [0.1, 0.2]
    moments.insert(place, 0.3 * (1.0 + excess))
    with pytest.raises(ScenarioError, match=r"airframe\.inertia = .*: no moment may exceed the sum of the other two"):
        check_inertia(Airframe(inertia=moments))
