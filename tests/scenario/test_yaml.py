import math

import pytest

from a2s_drake import Scenario, ScenarioError
from a2s_drake.scenario.field_values import field_value


def reason_of(text: str, **names: str) -> str:
    """Why a document is refused: one line, never long."""
    with pytest.raises(ScenarioError) as refusal:
        Scenario.from_yaml(text, source="mine.yaml", **names)
    message = str(refusal.value)
    assert "\n" not in message
    assert len(message) <= 1000
    return message


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (
            "mission: {radius: 2}\nlink: {}\nmission: {radius: 1}",
            "mine.yaml, line 3: mission is set twice, first in line 1",
        ),
        ("mission:\n  radius: 2\n\n  radius: 2\n", "mine.yaml, line 4: radius is set twice, first in line 2"),
        ("mission: {radius: 2, start: [0, 0, 0],\n  radius: 1}", "line 2: radius is set twice, first in line 1"),
        ("mission: {radius: 2, 'radius': 1}", "line 1: radius is set twice, first in line 1"),
        ("mission:\r\n  radius: 2\r\n  radius: 1\r\n", "line 3: radius is set twice, first in line 2"),
    ],
)
def test_nothing_is_set_twice(text: str, reason: str) -> None:
    assert reason in reason_of(text)


@pytest.mark.parametrize("name", ["mine", "yours"])
def test_no_scenario_is_named_twice(name: str) -> None:
    text = "mine: {}\nyours:\n  mission: {radius: 2}\nmine:\n  mission: {radius: 1}\n"
    assert reason_of(text, name=name) == "mine.yaml, line 4: mine is set twice, first in line 1"


@pytest.mark.parametrize("key", ["1", "1.5", "true", "null", "~", "[a]", "{}", "? [1, 2]\n"])
def test_keys_are_words(key: str) -> None:
    assert "mine.yaml, line 2: a key must be a word, is " in reason_of(f"# a note\n{key}: {{radius: 2}}")
    assert "mine.yaml, line 1: a key must be a word, is " in reason_of(f"{{mission: {{ {key}: 2}}}}")


@pytest.mark.parametrize(
    ("written", "number"),
    [
        *[("2", 2.0), ("-1", -1.0), ("+1", 1.0), ("0", 0.0), ("-0", 0.0), ("0.5", 0.5), (".5", 0.5), ("-.5", -0.5)],
        *[("2.", 2.0), ("5.8e9", 5800000000.0), ("3e9", 3000000000.0), ("1e-5", 0.00001), ("1E+2", 100.0)],
        *[("1e05", 100000.0), (".5e1", 5.0), ("2  # a note", 2.0), (".inf", math.inf), ("-.inf", -math.inf)],
    ],
)
def test_numbers_are_read_as_meant(written: str, number: float) -> None:
    for dut in (
        Scenario.from_yaml(f"mission:\n  radius: {written}"),
        Scenario().with_overrides([f"mission.radius={written}"]),
    ):
        assert dut.mission.radius == number
        assert type(dut.mission.radius) is float


@pytest.mark.parametrize(
    ("written", "advice"),
    [
        ("020", "must be a number, written without leading zeros"),
        ("-020.5", "must be a number, written without leading zeros"),
        ("1:30", "must be a number, written without colons"),
        ("1:30.5", "must be a number, written without colons"),
        ("0x10", "must be a number, written in decimal digits"),
        ("0o10", "must be a number, written in decimal digits"),
        ("0b10", "must be a number, written in decimal digits"),
        ("1_000", "must be a number, written without underscores"),
        ("2,5", "must be a number, written with a decimal point"),
        ("20 m", "must be a number, written without a unit"),
        ("'2'", "must be a number, written without quotes"),
        ('"5.8e9"', "must be a number, written without quotes"),
        ("|\n    2", "must be a number, written without quotes"),
        *[
            (word, "must be a number")
            for word in ("true", "no", "2026-11-24", "nan", "~", "", "[2]", "{x: 2}", "\u0662")
        ],
    ],
)
def test_what_only_looks_like_a_number_is_refused(written: str, advice: str) -> None:
    message = reason_of(f"mission:\n  radius: {written}")
    assert message.startswith("mine.yaml, line 2: mission.radius = ")
    assert message.endswith(advice)
    with pytest.raises(ScenarioError, match=r"^mission\.radius = .*must be a number"):
        Scenario().with_overrides([f"mission.radius={written}"])


@pytest.mark.parametrize("written", ["20.0", "2e1", "20.", "'20'", "020", "true", "20.5", "null", "[20]"])
def test_whole_numbers_are_written_as_such(written: str) -> None:
    assert "mpc.horizon = " in reason_of(f"mpc: {{horizon: {written}}}")
    with pytest.raises(ScenarioError, match=r"^mpc\.horizon = .*must be a whole number"):
        Scenario().with_overrides([f"mpc.horizon={written}"])


@pytest.mark.parametrize("written", ["yes", "on", "y", "1", "0", "'true'", "null", "[true]"])
def test_only_true_and_false_are_truth_values(written: str) -> None:
    assert "must be true or false" in reason_of(f"mpc: {{feedforward: {written}}}")
    for word, value in {"true": True, "True": True, "TRUE": True, "false": False, "False": False}.items():
        assert Scenario.from_yaml(f"mpc: {{feedforward: {word}}}").mpc.feedforward is value


@pytest.mark.parametrize("written", ["3", "1.5", "true", "null", "[level]", "{level: 1}"])
def test_words_are_words(written: str) -> None:
    assert reason_of(f"attitude_law: {{name: {written}}}").endswith("must be a word")
    assert Scenario.from_yaml("attitude_law: {name: 'level'}").attitude_law.name == "level"


@pytest.mark.parametrize(
    ("written", "reason"),
    [
        ("3", "mission.start = 3: must be a list of numbers"),
        ("0 0 0", "mission.start = '0 0 0': must be a list of numbers"),
        ("{x: 1}", "mission.start = {'x': 1}: must be a list of numbers"),
        ("[1, [2], 3]", "mission.start[1] = [2]: must be a number"),
        ("[1, a, 3]", "mission.start[1] = 'a': must be a number"),
        ("[1, 2, '3']", "mission.start[2] = '3': must be a number, written without quotes"),
        ("[1, null, 3]", "mission.start[1] = None: must be a number"),
        ("[1, true, 3]", "mission.start[1] = True: must be a number"),
    ],
)
def test_lists_hold_numbers(written: str, reason: str) -> None:
    assert f"mine.yaml, line 1: {reason}" in reason_of(f"mission: {{start: {written}}}")
    assert Scenario.from_yaml("mission:\n  start:\n  - 1\n  - -2e0\n  - .5\n").mission.start == [1.0, -2.0, 0.5]


def test_null_is_for_what_may_be_null() -> None:
    dut = Scenario.from_yaml("simulation: {duration: 3}")
    for written in ("null", "~", ""):
        assert dut.with_overrides([f"simulation.duration={written}"]).simulation.duration is None
    for value in ("'null'", "none"):
        assert "must be a number or null" in reason_of(f"simulation: {{duration: {value}}}")


def test_other_types_can_be_declared() -> None:
    for hint, value in {str | None: "a", int | None: 3, list[int]: [1, 2], list[str] | None: ["a"]}.items():
        assert field_value("a.b", value, hint) == value
    assert field_value("a.b", None, str | None) is field_value("a.b", None, int | None) is None
    others = {str | None: 3, int | None: 1.5, list[int]: [1, 2.0], list[str] | None: "a", list[bool]: 1}
    for hint, other in others.items():
        with pytest.raises(ScenarioError, match=r"^a\.b.* = .*: must be a"):
            field_value("a.b", other, hint)


@pytest.mark.parametrize("digits", [310, 500, 5000])
@pytest.mark.parametrize("field", ["mission.radius", "mpc.horizon", "disturbance.noise_seed", "simulation.duration"])
def test_huge_integers_are_refused_and_not_written_out(field: str, digits: int) -> None:
    with pytest.raises(ScenarioError, match=field) as refusal:
        Scenario().with_value(field, 10**digits).validate()
    with pytest.raises(ScenarioError) as read:
        Scenario().with_overrides([f"{field}=1{digits * '0'}"]).validate()
    with pytest.raises(ScenarioError, match=r"must be a .*number") as quoted:
        Scenario().with_value(field, digits * "9")
    assert max(len(str(refused.value)) for refused in (refusal, read, quoted)) < 250


def test_a_changed_copy_shares_nothing(scenario: Scenario) -> None:
    dut = scenario.with_value("mission.radius", 2.0)
    dut.mission.start[0] = dut.link.antenna_offset[0] = 1e3
    assert scenario == Scenario()
