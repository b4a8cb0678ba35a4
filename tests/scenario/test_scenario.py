import dataclasses
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from a2s_drake import Scenario, ScenarioError
from a2s_drake.flight.feasible import check
from diagrams import SCENARIOS, load_scenario


def test_defaults_are_table_i() -> None:
    dut = Scenario()
    assert (dut.airframe.mass, dut.airframe.inertia) == (2.57, [0.11, 0.11, 0.19])
    assert dut.link.antenna_offset == [0.39, 0.39, 0.195]
    assert (dut.airframe.rotor_speed_min, dut.airframe.rotor_speed_max) == (16.0, 100.0)
    assert (dut.link.carrier_hz, dut.link.reflection_magnitude, dut.link.ship_antenna_height) == (3e9, 0.8, 10.0)
    assert (dut.mission.ship_start, dut.mission.ship_end, dut.mission.sea_level) == ([90.0, 0.0], [100.0, 0.0], -20.0)
    assert (dut.mission.radius, dut.mission.duration) == (2.65, 40.0)
    assert (dut.link.transmit_power_dbm, dut.link.noise_power_dbm) == (10.0, -80.0)
    assert (dut.mpc.period, dut.mpc.horizon) == (0.02, 30)
    assert (dut.mpc.position_weight, dut.mpc.attitude_weight, dut.mpc.velocity_weight) == (100.0, 50.0, 1.0)
    assert (dut.mpc.angular_velocity_weight, dut.mpc.input_weight) == (10.0, 3.2e-8)
    assert (dut.mpc.velocity_limit, dut.mpc.angular_velocity_limit, dut.mpc.attitude_limit_deg) == (1.0, 1.0, 15.0)
    assert (dut.attitude_law.temperature, dut.attitude_law.index_min, dut.attitude_law.index_max) == (7.0, -50, 50)


@pytest.mark.parametrize("name", ["paper", "paper_calibrated", "hover", "tilt35"])
def test_named_scenarios_can_be_flown(name: str) -> None:
    load_scenario(name).validate()


def test_paper_changes_nothing() -> None:
    assert load_scenario("paper") == Scenario()


def test_calibrated_readings() -> None:
    dut = load_scenario("paper_calibrated")
    assert dut.link.wavelength == pytest.approx(0.1, rel=1e-15)
    assert (dut.attitude_law.candidate_limit_deg, dut.attitude_law.fallback) == (30.0, "zero")
    assert dut.mpc.attitude_limit_deg == 15.0


@given(
    mass=st.floats(0.1, 10.0),
    carrier=st.floats(1e8, 1e10),
    start=st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3),
    duration=st.none() | st.floats(1.0, 100.0),
)
def test_yaml_round_trip_is_exact(mass: float, carrier: float, start: list[float], duration: float | None) -> None:
    dut = Scenario()
    dut.airframe.mass, dut.link.carrier_hz, dut.mission.start = mass, carrier, start
    dut.simulation.duration = duration
    assert Scenario.from_yaml(dut.to_yaml()) == dut


def test_every_field_reaches_the_yaml() -> None:
    text = Scenario().to_yaml()
    for section in dataclasses.fields(Scenario):
        for entry in dataclasses.fields(section.default_factory):
            # An optional field is absent while it is null.
            assert f"{entry.name}:" in text or entry.default is None


def test_overrides_change_only_what_they_name() -> None:
    dut = Scenario().with_overrides(["mpc.horizon=20", "link.carrier_hz=5.8e9", "mission.start=[1, 2, 3]"])
    assert (dut.mpc.horizon, dut.link.carrier_hz, dut.mission.start) == (20, 5.8e9, [1.0, 2.0, 3.0])
    assert Scenario().mpc.horizon == 30
    back = dut.with_overrides(["mpc.horizon=30", "link.carrier_hz=3e9", "mission.start=[0, 0, 0]"])
    assert back == Scenario()


numeric_fields = [
    f"{section.name}.{entry.name}"
    for section in dataclasses.fields(Scenario)
    for entry in dataclasses.fields(section.default_factory)
    if not {"choices", "file"} & set(entry.metadata)
]


@given(st.sampled_from(numeric_fields), st.floats() | st.integers() | st.sampled_from([0, -1, 1e-300, 1e300, -1e300]))
def test_any_number_in_any_field_is_either_flown_or_refused_in_one_line(field: str, value: float) -> None:
    part = getattr(Scenario(), field.split(".")[0])
    if isinstance(getattr(part, field.split(".")[1]), list):
        value = [value] * len(getattr(part, field.split(".")[1]))
    try:
        Scenario().with_value(field, value).validate()
    except ScenarioError as refusal:
        assert "\n" not in str(refusal)


@pytest.mark.parametrize("field", numeric_fields)
@pytest.mark.parametrize("value", [1e300, -1e300])
def test_no_field_goes_without_limits(field: str, value: float) -> None:
    section, name = field.split(".")
    entry = getattr(getattr(Scenario(), section), name)
    dut = Scenario()
    setattr(getattr(dut, section), name, [value] * len(entry) if isinstance(entry, list) else value)
    with pytest.raises(ScenarioError, match=field):
        dut.validate()


def test_an_empty_document_is_table_i() -> None:
    assert Scenario.from_yaml("") == Scenario.from_yaml("{mpc: }") == Scenario()


@pytest.mark.parametrize(
    ("override", "field", "reason"),
    [
        ("airframe.mass=-1", "airframe.mass = -1.0", "at least 0.001"),
        ("airframe.mass=.nan", "airframe.mass = nan", "finite"),
        ("link.carrier_hz=.inf", "link.carrier_hz = inf", "finite"),
        ("link.antenna_offset=[0, .nan, 0]", "link.antenna_offset", "finite"),
        ("airframe.inertia=[0.1, 0.1]", "airframe.inertia = [0.1, 0.1]", "3 entries, has 2"),
        ("airframe.inertia=[0.1, -0.1, 0.1]", "airframe.inertia", "at least 1e-06"),
        ("airframe.inertia=[0.1, 0.1, 0.3]", "airframe.inertia", "sum of the other two"),
        ("airframe.drag_sign=0", "airframe.drag_sign = 0", "-1, 1"),
        ("airframe.rotor_speed_min=100", "airframe.rotor_speed_min = 100.0", "below airframe.rotor_speed_max = 100.0"),
        ("airframe.mass=8", "airframe.mass = 8.0", "hover takes 108.84 Hz"),
        (
            "airframe.thrust_coefficient=0.02",
            "airframe.mass = 2.57 with airframe.thrust_coefficient",
            "hover takes",
        ),
        ("mission.sea_level=0", "mission.sea_level = 0.0", "below mission.start[2] = 0.0"),
        ("mission.start=[0, 0, -25]", "mission.sea_level = -20.0", "below mission.start[2] = -25.0"),
        ("mission.sea_level=-0.01", "link.antenna_offset", "below the UAV"),
        ("link.ship_antenna_height=-1", "link.ship_antenna_height = -1.0", "above 0"),
        ("link.reflection_magnitude=1.1", "link.reflection_magnitude = 1.1", "at most 1"),
        ("mission.duration=20", "mission.duration = 20.0", "at least 26.1"),
        ("mission.duration=0", "mission.duration = 0.0", "at least 0.001"),
        ("mpc.velocity_limit=0.5", "mission.duration = 40.0", "at least 52.3"),
        ("simulation.duration=0.01", "simulation.duration = 0.01", "at least one period"),
        ("mpc.horizon=0", "mpc.horizon = 0", "at least 1"),
        ("mpc.period=0", "mpc.period = 0.0", "at least 0.0001"),
        ("mpc.period=-0.02", "mpc.period = -0.02", "at least 0.0001"),
        ("mpc.period=1e-9", "mpc.period = 1e-09", "at least 0.0001"),
        ("mpc.position_lower=[-5, -5, -5]", "mpc.position_lower", "operating region"),
        ("mpc.position_upper=[10, 10, -10]", "mpc.position_lower", "below mpc.position_upper"),
        ("mpc.solver=snopt", "mpc.solver = 'snopt'", "piqp, osqp, ipopt"),
        ("attitude_law.name=yaw", "attitude_law.name = 'yaw'", "three_axis, pitch_only, level"),
        ("attitude_law.index_max=-51", "attitude_law.index_min = -50", "at most attitude_law.index_max"),
        ("attitude_law.index_max=42", "attitude_law.index_max = 42", "39..43"),
        ("attitude_law.index_min=40", "attitude_law.index_min = 40", "39..43"),
        ("mission.sea_level=-24", "attitude_law.index_max = 50", "46..51"),
    ],
)
def test_refuses_what_cannot_be_flown(override: str, field: str, reason: str) -> None:
    with pytest.raises(ScenarioError) as refusal:
        check(Scenario().with_overrides([override]))
    message = str(refusal.value)
    assert message.startswith(field)
    assert reason in message
    assert "\n" not in message


def test_level_law_needs_no_index_window() -> None:
    check(Scenario().with_overrides(["mission.sea_level=-24", "attitude_law.name=level"]))


@pytest.mark.parametrize(
    ("override", "reason"),
    [
        ("mpc.horizon=3.5", "mpc.horizon = 3.5: must be a whole number"),
        ("airframe.mass=heavy", "airframe.mass = 'heavy': must be a number"),
        ("airframe.inertia=0.1", "airframe.inertia = 0.1: must be a list of numbers"),
        ("airframe.mass=", "airframe.mass = None: must be a number"),
        ("mpc.horizn=3", "mpc.horizn: no such field; mpc has: solver, period, horizon"),
        ("nmpc.horizon=3", "nmpc.horizon: no such section; there are: airframe, link"),
        ("mpc.horizon", "section.field=value"),
        ("mpc.horizon=[", "'mpc.horizon=[', line 1: cannot be read as YAML"),
    ],
)
def test_refuses_overrides_that_name_nothing(override: str, reason: str) -> None:
    with pytest.raises(ScenarioError) as refusal:
        Scenario().with_overrides([override])
    assert reason in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[1, 2", "cannot be read as YAML"),
        ("0", "must be a map"),
        ("{airframe: []}", "must be a map"),
        ("[1, 2]", "must be a map"),
        ("{airframe: 3}", "must be a map"),
        ("{airframe: {mas: 3}}", "airframe.mas: no such field"),
        ("{plane: {mass: 3}}", "line 1: plane: no such section"),
    ],
)
def test_refuses_yaml_that_holds_no_scenario(text: str, reason: str) -> None:
    with pytest.raises(ScenarioError, match=reason):
        Scenario.from_yaml(text)


def test_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(ScenarioError, match="paper, paper_calibrated, hover, tilt35"):
        Scenario.from_yaml(SCENARIOS.read_text(), name="papper")


@pytest.mark.parametrize(("duration", "samples"), [(40.0, 2001), (0.02, 2), (0.06, 4), (0.05, 3), (0.3, 16)])
def test_samples_include_both_ends(duration: float, samples: int) -> None:
    dut = Scenario()
    dut.simulation.duration = duration
    times = dut.sample_times()
    assert len(times) == samples
    assert times[0] == 0.0
    assert times[-1] <= duration * (1 + 1e-12)


def test_a_missing_solver_is_named_before_the_flight(scenario: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "piqp", None)
    with pytest.raises(ScenarioError, match=r"mpc.solver = 'piqp'.*pip install piqp.*osqp needs only Drake"):
        check(scenario)
    check(scenario.with_overrides(["mpc.solver=osqp"]))
