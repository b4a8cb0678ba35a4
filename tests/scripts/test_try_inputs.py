"""What the trial of inputs calls a fault, and what it lets pass, over made-up scripts that end in one way each."""

import math
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest

from a2s_drake import Scenario
from scripts import try_inputs
from scripts.trial.case import Case
from scripts.trial.draw import case_of, labels
from scripts.trial.isolation import endings
from scripts.trial.scenarios import FIELDS, draw
from scripts.trial.verdict import FAULT, FLOWN, REFUSED, SENTENCE, judge

REFUSAL = "import sys; print('error: mpc.horizon = 0: must be at least 1', file=sys.stderr); {more}; sys.exit(2)"
FLIGHT = """
from pathlib import Path
from scripts import flying
from tests.support.flights import made_up_flight
flying.write_results(made_up_flight(), Path("out"))
"""
ENDED = "import sys; print('error: the flight ended at t = 0.1 s: {why}', file=sys.stderr); sys.exit(1)"
CHANGED = "metrics = Path('out/metrics.json'); metrics.write_text(metrics.read_text().replace({old!r}, {new!r}))"

# A script, the ending it comes to and what is said against it.
SCRIPTS = {
    "good flight": (FLIGHT, FLOWN, ""),
    "good refusal": (REFUSAL.format(more="0"), REFUSED, ""),
    "good sentence": (FLIGHT + ENDED.format(why="the vehicle turns too fast"), SENTENCE, ""),
    "warning of ours": (FLIGHT + "import sys; print('warning: the plan is short', file=sys.stderr)", FLOWN, ""),
    "traceback": ("[][0]", FAULT, "a traceback"),
    "abort": ("import os; os.abort()", FAULT, "ended by signal 6"),
    "hang": ("import time; time.sleep(60.0)", FAULT, "still running after 3 s"),
    "endless loop in a child": (
        "import subprocess, sys; subprocess.run([sys.executable, '-c', 'while True: pass'])",
        FAULT,
        "still running after 3 s",
    ),
    "other exit code": ("import sys; sys.exit(3)", FAULT, "exit 3"),
    "two lines": (REFUSAL.format(more="print('and more', file=sys.stderr)"), FAULT, "2 lines"),
    "no line": ("import sys; sys.exit(2)", FAULT, "0 lines"),
    "long line": (REFUSAL.format(more="0").replace("must", "x" * 500), FAULT, "characters long"),
    "control character": (REFUSAL.format(more="0").replace("must", "\\x1b[31m"), FAULT, "control character"),
    "no name": (REFUSAL.format(more="0").replace("mpc.horizon", "it"), FAULT, "names no field, option or file"),
    "refused after writing": (REFUSAL.format(more="open('out.txt', 'w').close()"), FAULT, "wrote out.txt"),
    "refused on stdout": (REFUSAL.format(more="print('bad')"), FAULT, "printed on stdout"),
    "exit 0 without a flight": ("", FAULT, "0 files flight.npz"),
    "NaN in the metrics": (
        FLIGHT + CHANGED.format(old='"position_error_max_m": 0.0', new='"position_error_max_m": NaN'),
        FAULT,
        "NaN is no number of JSON",
    ),
    "infinite in the metrics": (FLIGHT + CHANGED.format(old='"samples": 5', new='"samples": 1e999'), FAULT, "is inf"),
    "null in the metrics": (FLIGHT + CHANGED.format(old='"samples": 5', new='"samples": null'), FAULT, "is None"),
    "NaN in the flight": (
        "import numpy as np" + FLIGHT.replace("()", "(snr_db=np.full(5, np.nan))"),
        FAULT,
        "snr_db is not 5 finite rows",
    ),
    "warning of numpy": (
        FLIGHT + "from scripts.common import show_warnings; show_warnings(); import numpy as np; np.exp(np.array(1e9))",
        FAULT,
        "a warning that is not in our words",
    ),
    "not a number printed": (FLIGHT + "print('three_axis: nan bit/Hz')", FAULT, "not finite"),
    "ended in Drake's words": (
        FLIGHT + ENDED.format(why="Failure at x.cc:12 in Solve(): condition \\'a < b\\' failed."),
        FAULT,
        "not in our words",
    ),
    "other metrics than the flight's": (
        FLIGHT + CHANGED.format(old='"samples": 5', new='"samples": 6'),
        FAULT,
        "6 samples, flight.npz has 5",
    ),
    "no metrics": (FLIGHT + "Path('out/metrics.json').unlink()", FAULT, "without metrics.json"),
    "damaged flight": (FLIGHT + "Path('out/flight.npz').write_bytes(b'PK')", FAULT, "cannot be loaded"),
    "rubbish on stderr": (FLIGHT + "import sys; print('hm', file=sys.stderr)", FAULT, "no warning of ours"),
    "no error": (REFUSAL.format(more="0").replace("error: ", ""), FAULT, "does not start with 'error: '"),
    "ended without samples": (ENDED.format(why="the vehicle turns too fast"), FAULT, "no samples are kept"),
}


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[str, str]]:
    """The verdict on each of `SCRIPTS`, all of which have run."""
    folder = tmp_path_factory.mktemp("trial")
    cases = []
    for number, (name, (text, *_)) in enumerate(SCRIPTS.items()):
        script = folder / f"script_{number}" / "simulate.py"
        script.parent.mkdir()
        script.write_text(text)
        waits = 3.0 if "still running" in SCRIPTS[name][2] else 60.0
        cases.append(Case((), script=str(script), label=f"case_{number}", kind=name, timeout=waits))
    verdicts = {case.kind: judge(case, ending, folder / case.label) for case, ending in endings(cases, folder, 2)}
    return verdicts.__getitem__


@pytest.mark.parametrize("name", SCRIPTS)
def test_an_ending_is_told_for_what_it_is(name: str, judged: Callable[[str], tuple[str, str]]) -> None:
    kind, wrong = judged(name)
    _, expected, reason = SCRIPTS[name]
    assert (kind, reason in wrong) == (expected, True), wrong


@pytest.fixture(scope="module")
def run_one(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Case], tuple[str, str]]:
    """The verdict on one case of a script of the project."""

    def run(case: Case) -> tuple[str, str]:
        folder = tmp_path_factory.mktemp("one")
        ((_, ending),) = endings([replace(case, label="it")], folder, 1)
        return judge(case, ending, folder / "it")

    return run


SHORT = ("--duration", "0.1", "--set", "mpc.horizon=5", "--out", "out")


@pytest.mark.parametrize("fresh", [False, True])
def test_a_script_of_the_project_ends_well(fresh: bool, run_one: Callable[[Case], tuple[str, str]]) -> None:
    assert run_one(Case(("paper", *SHORT), fresh=fresh)) == (FLOWN, "")
    file = {"own.yaml": b"mission:\n  radius: -1\n"}
    assert run_one(Case(("own.yaml", *SHORT), file, fresh=fresh, must_refuse=True)) == (REFUSED, "")


def test_what_must_be_refused_and_is_flown_is_a_fault(run_one: Callable[[Case], tuple[str, str]]) -> None:
    assert run_one(Case(("paper", *SHORT), must_refuse=True)) == (FAULT, "accepted, and must be refused")


def test_what_must_be_refused_and_ends_early_is_a_fault(run_one: Callable[[Case], tuple[str, str]], tmp_path) -> None:
    script = tmp_path / "simulate.py"
    script.write_text(SCRIPTS["good sentence"][0])
    assert run_one(Case((), script=str(script), must_refuse=True)) == (FAULT, "exit 1, and must be refused with 2")


def test_a_case_that_hangs_is_ended_with_its_workers(tmp_path: Path) -> None:
    worker = (
        "import time; ticks = open('ticks', 'a', buffering=1)\nwhile True: print('tick', file=ticks); time.sleep(0.05)"
    )
    script = tmp_path / "simulate.py"
    script.write_text(f"import subprocess, sys; subprocess.run([sys.executable, '-c', {worker!r}])")
    ((_, ending),) = endings([Case((), script=str(script), label="it", timeout=5.0)], tmp_path, 1)
    ticks = tmp_path / "it" / "work" / "ticks"
    counted = ticks.stat().st_size
    time.sleep(0.5)
    assert ending.code is None
    assert 0 < counted == ticks.stat().st_size


def test_one_seed_draws_the_same_cases_twice_and_another_draws_others() -> None:
    chosen = labels(40, 40)
    assert [case_of(label, 3) for label in chosen] == [case_of(label, 3) for label in chosen]
    assert [case_of(label, 3) for label in chosen] != [case_of(label, 4) for label in chosen]


def test_a_case_depends_on_its_label_alone() -> None:
    assert labels(3, 2) == ["s0", "b0", "s1", "b1", "s2"]
    assert labels(0, 2) == ["b0", "b1"]


def test_every_field_is_drawn() -> None:
    drawn = set()
    for label in labels(2000, 0):
        case = case_of(label, 0)
        drawn |= {text.partition("=")[0] for text in case.arguments if "=" in text}
    assert set(FIELDS) <= drawn


def test_values_are_drawn_over_the_whole_range_and_at_its_ends() -> None:
    rng = Random(0)
    for name, field in FIELDS.items():
        limits = field.metadata
        if "choices" in limits:
            assert {draw(rng, field, field.default) for _ in range(100)} == set(limits["choices"])
        elif "file" in limits:
            assert draw(rng, field, field.default) is None
        elif "length" not in limits:
            values = {draw(rng, field, field.default) for _ in range(300)}
            low, high = limits.get("at_least", -math.inf), limits.get("at_most", math.inf)
            assert low <= min(values) <= max(values) <= high, name
            assert limits.get("above", -math.inf) < min(values), name
            assert max(values) < limits.get("below", math.inf), name
            assert {limits[key] for key in ("at_least", "at_most") if key in limits} <= values, name
            assert len(values) > 60 or high - low < 200, name


def test_a_scenario_as_a_file_and_as_overrides_holds_values_of_the_right_kind() -> None:
    for label in labels(60, 0):
        case = case_of(label, 1)
        for content in case.files.values():
            Scenario.from_yaml(content.decode())
        if "--set" in case.arguments:
            start = case.arguments.index("--set") + 1
            Scenario().with_overrides(text for text in case.arguments[start:] if "=" in text)


def test_a_case_can_be_typed_again(tmp_path: Path) -> None:
    odd = "a \n\x1b'\"$(x)\\ü\udcff"
    case = Case((odd, "plain"), {"f.yaml": b"a\n\0\xff'7%\\", odd.replace("/", ""): b""}, {"l": "f.yaml"}, ("d",))
    script = tmp_path / "show.py"
    script.write_text("import sys, os; print(sys.argv[1:], open('l', 'rb').read(), sorted(os.listdir()))")
    typed = replace(case, script=str(script)).typed(tmp_path).replace("python ", f"{sys.executable} ")
    printed = subprocess.run(["bash", "-c", typed], capture_output=True, text=True, check=True).stdout
    files = sorted([odd, "f.yaml", "l", "d"])
    assert printed == f"{[odd, 'plain']} {case.files['f.yaml']} {files}\n"


@pytest.mark.parametrize(
    ("arguments", "reason"), [(["--jobs", "0"], "--jobs 0"), (["--only", "x3"], "'x3'"), (["--bad", "-1"], "--bad -1")]
)
def test_options_that_cannot_be_worked_with_are_refused(arguments: list[str], reason: str, capsys) -> None:
    assert try_inputs.main(arguments) == 2
    assert reason in capsys.readouterr().err


def test_a_fault_is_shown_with_what_to_type(monkeypatch, capsys, tmp_path: Path) -> None:
    script = tmp_path / "simulate.py"
    script.write_text("[][0]")
    monkeypatch.setattr(try_inputs, "case_of", lambda label, _: Case(("a b",), script=str(script), label=label))
    assert try_inputs.main(["--only", "s1", "--jobs", "1"]) == 1
    printed = capsys.readouterr().out
    assert f"python {script} 'a b'" in printed
    assert "IndexError" in printed
    assert "1 faults" in printed


@pytest.mark.slow
def test_no_input_ends_in_a_fault() -> None:
    process = subprocess.run(
        [sys.executable, "scripts/try_inputs.py"], capture_output=True, text=True, check=False, timeout=1800
    )
    assert process.returncode == 0, process.stdout + process.stderr
