"""Input that nobody means to give: it is read as meant, or refused in one short line that says where."""

import time
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from a2s_drake import Flight, Scenario, ScenarioError
from diagrams import load_scenario
from scripts import common, compare, missions, robustness, simulate
from tests.support.flights import made_up_flight

BOMB = "a: &a [x, x]\n" + "".join(
    f"{new}: &{new} [*{old}, *{old}]\n" for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)


def refusal_of(call: Callable[[], Any], longest: int = 400) -> str:
    """What a call is refused with: one line, soon, and not long."""
    start = time.monotonic()
    with pytest.raises(ScenarioError) as refusal:
        call()
    assert time.monotonic() - start < 5.0
    message = str(refusal.value)
    assert "\n" not in message
    assert len(message) <= longest
    return message


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("mission: {start: &s [1, 2, 3]}", "line 1: anchors and aliases (& and *) are not read"),
        ("# a note\nmission: {start: *s}", "line 2: anchors and aliases"),
        (BOMB, "line 1: anchors and aliases"),
        ("mission: &m\n  <<: *m", "line 1: anchors and aliases"),
        ("mission: {radius: !!float 2}", "line 1: tags (here 'tag:yaml.org,2002:float') are not read"),
        ("mission:\n  radius: !!python/object/apply:os.getcwd []", "line 2: tags (here 'tag:yaml.org,2002:python/"),
        ("!mine {radius: 2}", "line 1: tags (here '!mine') are not read"),
        (f"mission: !{'x' * 5000} 2", "are not read; write the value alone"),
        ("mission: {radius: 2}\n---\nlink: {}\n", "line 2: cannot be read as YAML: expected a single document"),
        ("mission: {start: [1, 2}", "line 1: cannot be read as YAML"),
        ("mission:\n\tradius: 2", "line 2: cannot be read as YAML: "),
        ("[" * 20_000, "line 1: a value is nested more than 16 levels deep"),
        ("- " * 20_000, "line 1: a value is nested more than 16 levels deep"),
        ("{a: " * 5_000 + "1" + "}" * 5_000, "line 1: a value is nested more than 16 levels deep"),
        ("mission: {radius: 2}\n\n# \x07", "line 3: holds the control character U+0007"),
        ("# a note\x85mission: {radius: 1}", "line 1: holds the control character U+0085"),
        ("# a note\u2028mission: {radius: 1}", "line 1: holds the control character U+2028"),
        ('mission: {"\\UFFFFFFFF": 1}', "line 1: cannot be read as YAML"),
        (f"%YAML {'9' * 5000}.1\n---\n{{}}", "line 1: cannot be read as YAML"),
        ("misson:", "line 1: misson: no such section"),
        ("mission.radius: 2", "line 1: mission.radius: no such section"),
        ("mission:2", "a scenario must be a map of settings, is 'mission:2'"),
        ("x" * 10_000_000, "is longer than 200000 characters"),
        (f"mission: {{start: [{'1, ' * 30_000}]}}", "mission.start = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, ...]"),
        (f"mission: {{radius: '{'x' * 100_000}'}}", "xxx': must be a number"),
        (f"mission: {{? {'x' * 100_000}\n : 1}}", "xxx': no such field"),
        (f"? {'x' * 100_000}\n: 1", "xxx': no such section"),
        ('mission: {"ra\\ndius\\e": 1}', r"'mission.ra\ndius\x1b': no such field"),
        ('attitude_law: {name: "lev\\nel"}', r"attitude_law.name = 'lev\nel'"),
        (f"{{{'x' * 1000}: 1, {'x' * 1000}: 1}}", "xxx' is set twice, first in line 1"),
    ],
    ids=range(30),
)
def test_odd_yaml_is_refused_in_a_line(text: str, reason: str) -> None:
    assert reason in refusal_of(lambda: Scenario.from_yaml(text, source="mine.yaml").validate())


def test_no_refusal_takes_more_than_a_line() -> None:
    assert str(ScenarioError("a\nb\x1b[0m\u2028")) == r"a\nb\x1b[0m\u2028"
    assert len(str(ScenarioError("\n" * 9999))) <= 1000


@given(st.text(st.sampled_from("{}[],:?-!&*|>'\"%@`#~\n\r\t \\019.eE_+ax\x00\x85\ufeff\ud800")))
def test_any_text_is_read_or_refused_in_a_line(text: str) -> None:
    for read in (lambda: Scenario.from_yaml(text), lambda: Scenario().with_overrides([f"mission.radius={text}"])):
        try:
            read()
        except ScenarioError as refusal:
            assert "\n" not in str(refusal)


@pytest.mark.parametrize(
    ("content", "radius"),
    [
        (b"", 2.65),
        (b"# nothing but a note\n\n", 2.65),
        (b"\xef\xbb\xbfmission: {radius: 2}\n", 2.0),
        (b"mission:\r\n  radius: 2  # m\r\n", 2.0),
        (b"%YAML 1.2\n---\nmission: {radius: 2}\n...\n", 2.0),
        ("mission: {radius: 2}  # \u00e0 vol d'oiseau".encode(), 2.0),
    ],
)
def test_files_are_read_however_they_were_written(content: bytes, radius: float, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_bytes(content)
    assert load_scenario(str(path)).mission.radius == radius


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"mission: {radius: 2}\n\n# \xe0 vol", ", line 3: is not UTF-8 text"),
        ("mission: {radius: 2}".encode("utf-16"), ", line 1: is not UTF-8 text"),
        (b"mission: {radius: 2}\n\x00", ", line 2: holds the control character U+0000"),
        (b"#" * 10_000_000, ": is longer than 200000 characters"),
        (b"##" + "\u00e9".encode() * 5_000_000, ": is longer than 200000 characters"),
        (b"mission:\n  radius: two\n", ", line 2: mission.radius = 'two': must be a number"),
        (None, ": Is a directory"),
    ],
)
def test_files_that_hold_no_settings_are_named(content: bytes | None, reason: str, tmp_path: Path, refuses) -> None:
    path = tmp_path / "mine.yaml"
    if content is None:
        path.mkdir()
    else:
        path.write_bytes(content)
    assert f"{path}{reason}" in refusal_of(lambda: load_scenario(str(path)))
    refuses(simulate, [str(path)], reason)


def test_a_kept_flight_names_the_file_that_is_not_text(tmp_path: Path) -> None:
    made_up_flight().save(tmp_path)
    (tmp_path / "scenario.yaml").write_bytes(b"# \xe0\n")
    assert f"{tmp_path / 'scenario.yaml'}, line 1: is not UTF-8" in refusal_of(lambda: Flight.load(tmp_path))


@pytest.mark.parametrize("name", ["x" * 5000, "x" * 5000 + ".yaml", "two\nlines", "two\nlines.yaml", ""])
def test_odd_names_of_scenarios_are_refused_in_a_line(name: str, refuses) -> None:
    refusal_of(lambda: load_scenario(name), longest=500)
    refuses(simulate, [name], "error: ")


def test_many_scenarios_are_not_all_listed() -> None:
    text = "".join(f"scenario_{place}: {{}}\n" for place in range(2000))
    assert "scenario_0, scenario_1, " in refusal_of(lambda: Scenario.from_yaml(text, name="mine"), longest=500)


@pytest.mark.parametrize(
    ("override", "reason"),
    [
        ("mission.radius=", "mission.radius = None: must be a number"),
        ("mission.start=[1, 2", "'mission.start=[1, 2', line 1: cannot be read as YAML"),
        ("mission.radius={x: 1}", "mission.radius = {'x': 1}: must be a number"),
        ("mission.radius={x: 1, x: 2}", "x is set twice"),
        ("mission.radius=&x 1", "'mission.radius=&x 1', line 1: anchors and aliases"),
        ("mission.radius=*x", "'mission.radius=*x', line 1: anchors and aliases"),
        ("mission.radius=!!python/name:os.getcwd", "tags (here"),
        (
            "mission.radius=--- 1\n--- 2",
            r"'mission.radius=--- 1\n--- 2', line 2: cannot be read as YAML: expected a single",
        ),
        (f"mission.radius={'[' * 5000}", "a value is nested more than 16 levels deep"),
        (f"mission.start=[{'1, ' * 10_000}]", "1.0, ...]: must have 3 entries, has 10000"),
        (f"mission.{'x' * 5000}=1", "xxx': no such field"),
        (f"{'x' * 5000}=1", "xxx': no such section"),
        ("x" * 5000, "xxx': an override has the form section.field=value"),
        ("mis\nsion=1", r"'mis\nsion': no such section"),
        ("mission .radius=2", "mission .radius: no such section"),
        ("mission. radius=2", "mission. radius: no such field"),
        ("=2", "'': no such section"),
    ],
    ids=range(17),
)
def test_odd_overrides_are_refused_in_a_line(override: str, reason: str, refuses) -> None:
    assert reason in refusal_of(lambda: Scenario().with_overrides([override]).validate())
    refuses(simulate, ["paper", "--set", override], reason)


@pytest.mark.parametrize(
    "text", ["mission.radius=2", " mission.radius = 2 ", "mission.radius=2 # a note", "mission.radius=2\n"]
)
def test_blanks_and_notes_around_an_override_mean_nothing(text: str) -> None:
    assert Scenario().with_overrides([text]).mission.radius == 2.0


@pytest.mark.parametrize("script", [compare, robustness])
@pytest.mark.parametrize("law", [" attitude_law.name=level", "attitude_law.name =level", "\tattitude_law.name = level"])
def test_blanks_hide_no_law(script, law: str, refuses) -> None:
    refuses(script, ["--duration", "0.04", "--set", law], "this script chooses the laws")


@pytest.mark.parametrize("setting", [" disturbance.mass_factor=2", "\n disturbance.mass_factor = 2"])
def test_blanks_hide_no_disturbance(setting: str, refuses) -> None:
    refuses(robustness, ["--duration", "0.04", "--set", setting], "this script chooses the disturbances")


@pytest.mark.parametrize("script", [compare, missions, robustness])
def test_scripts_that_choose_refuse_what_is_no_override(script, refuses) -> None:
    refuses(script, ["--set", "attitude_law.name"], "an override has the form section.field=value")


@pytest.mark.parametrize(
    "arguments",
    [["--duration", "x" * 9999], ["--duration", "two\nlines"], ["--law", "x" * 9999], ["--x\n" + "y" * 9999]],
)
def test_the_command_line_is_not_repeated_at_length(arguments: list[str], capsys) -> None:
    assert simulate.main(["paper", *arguments]) == 2
    printed = capsys.readouterr().err
    assert printed.count("\n") == 1
    assert len(printed) < 1100


@pytest.mark.parametrize(("duration", "shown"), [("nan", "nan"), ("inf", "inf"), ("-inf", "-inf"), ("1e999", "inf")])
def test_an_endless_duration_is_refused_by_its_range(duration: str, shown: str, refuses) -> None:
    refuses(simulate, ["paper", f"--duration={duration}"], f"simulation.duration = {shown}: must be finite")


@pytest.mark.parametrize(
    ("scenario", "folder"),
    [
        *[("paper", "paper"), ("mine.yaml", "mine"), ("./mine.yml", "mine"), ("a/b/mine.v2.yaml", "mine.v2")],
        *[("two words.yaml", "two words"), ("-x.yaml", "-x"), (".mine.yaml", "mine"), ("..yaml", "scenario")],
        *[("results/mine/scenario.yaml", "mine"), ("scenario.yaml", "here"), ("./scenario.yml", "here")],
        *[("../scenario.yaml", "above"), ("../../x/../scenario.yaml", "top"), ("/scenario.yaml", "scenario")],
        *[("v1.2", "v1.2"), ("scenario", "scenario"), ("..", "scenario"), ("", "scenario"), ("C:x.yaml", "C_x")],
        *[("a\\b.yaml", "a_b"), ("a\nb.yaml", "a_b")],
    ],
)
def test_results_go_by_the_scenario(scenario: str, folder: str, tmp_path: Path, monkeypatch) -> None:
    here = tmp_path / "top" / "above" / "here"
    here.mkdir(parents=True)
    monkeypatch.chdir(here)
    assert common.default_folder(Namespace(scenario=scenario)) == Path("results") / folder


@given(
    st.text(st.sampled_from("./\\: -~axC\n\x00\ud800") | st.characters()),
    st.sampled_from(["", ".yaml", "/scenario.yml"]),
)
def test_results_stay_in_results(name: str, ending: str) -> None:
    folder = common.default_folder(Namespace(scenario=(name + ending).replace("\x00", "")))
    for kind in (PurePosixPath, PureWindowsPath):
        first, *rest = kind(str(folder)).parts
        assert (first, len(rest)) == ("results", 1)
        assert rest[0].strip(" .") == rest[0] != ""
        assert kind(rest[0]).drive == ""


def test_a_scenario_above_is_flown_into_results(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "here").mkdir()
    Scenario().save(tmp_path / "scenario.yaml")
    monkeypatch.chdir(tmp_path / "here")
    assert simulate.main(["../scenario.yaml", "--duration", "0.04", "--set", "mpc.horizon=3"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"here", "scenario.yaml"}
    assert (tmp_path / "here" / "results" / tmp_path.name / "three_axis" / "metrics.json").exists()
