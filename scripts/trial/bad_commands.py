"""Bad commands: options, names and places for results that a script cannot work with."""

from collections.abc import Callable, Iterable
from random import Random

from scripts.trial.case import Case
from scripts.trial.commands import OUT, SHORT, scenario_command

_FLYING = ("simulate", "compare", "robustness", "benchmark")

# Texts that are no number, no name and no form of an override.
_TEXTS = (
    *("", " ", "x", "-", "--", "ünïcödé", "🚁", "\N{RIGHT-TO-LEFT OVERRIDE}x", "\N{ZERO WIDTH SPACE}", "\x1b[31mred"),
    *("a\nb", "a\rb", "\t", "\x07", "\x7f", "a\0b", "\udcff", "%s%n", "{0}", "$(true)", "'", '"'),
    *("x" * 300, "x" * 5000),
)
_NUMBERS = ("", "x", "1.5.2", "nan", "-1", "-0.001", "1e", "0x10", "²", "--", "1 2", "\0")
_JOBS = ("0", "-1", "-0", "x", "1.5", "1e3", "", "nan", "0x2", "-" + "9" * 30)
_DURATIONS = ("0", "-3", "nan", "inf", "-inf", "1e300", "1e-300", "0.019", "1e6", "86400.1", "1e999")
_OVERRIDES = (
    *("mass", "mass=1", "airframe", "airframe=1", "airframe={mass: 1}", "=1", "=", ".=1", "airframe.=1", ".mass=1"),
    *("airframe.mass", "airframe.mass.x=1", "airframe..mass=1", "Airframe.mass=1", "airframe.Mass=1", "a.b=c"),
    *("airframe.mass:1", "airframe .mass=1", "airframe.mass==1", "airframe.mass=[", "airframe.mass='", "air/mass=1"),
    *("airframe.mass=1: 2", "airframe.mass=&a *a", "airframe.mass=1 # x\n2", "airframe.__class__=1", "link.wave=1"),
    *("airframe.mass=*a", "airframe.mass={1: 2, 1: 3}", "airframe.mass=!!python/name:os.system", "airframe.mass=\0"),
)
_SCENARIOS = (
    *("papper", "Paper", "paper ", " paper", "paper,planned", "../paper", "paper.yaml", "scenarios", "null", "0"),
    *("__class__", "paper\0", "\N{CYRILLIC SMALL LETTER ER}aper", "~", "[]"),
)
_FILE = {"file": b"in the way"}
_TOO_LONG = ("x" * 300, "x" * 5000)
_PLACES = ("", "/dev/null", "/dev/null/x", "/dev/full", "/proc/x", "/proc/1/x", "a\0b", *_TOO_LONG)
_FILE_PLACES = ("", ".", "folder", "folder/", "file/x", "loop", "/dev/null/x", "/proc/x", "a\0b", *_TOO_LONG)
_ODD_PLACES = (
    *("ünï", "🚁", "a b", "-x", "a\nb", "\x1b[31m", "\udcff", "x" * 255, "d/" * 20 + "x", "./", ".", "folder/../out"),
    *("%s", "{x}", "~"),
)


def _each(script: str, commands: Iterable[tuple[str, ...]]) -> list[Case]:
    """Commands for one script, each with a folder for its results."""
    return [Case((*command, *OUT), script=script) for command in commands]


def _text_somewhere(rng: Random) -> Case:
    text = rng.choice(_TEXTS)
    simulated = (
        *((text,), ("paper", "--set", text), ("paper", "--set", f"airframe.{text}=1"), ("paper", f"--{text or 'y'}")),
        *(("paper", "--set", f"attitude_law.name={text}"), ("paper", f"--law={text}"), ("paper", "--duration", text)),
        (f"{text}.yaml",),
    )
    cases = (
        *_each("simulate", simulated),
        *_each(rng.choice(_FLYING), [("paper", text)]),
        *_each("missions", [(text,)]),
        *_each("reproduce", [(text,)]),
        Case((text,), script="show_diagram"),
        Case(("closed_loop", "--scenario", text), script="show_diagram"),
    )
    return rng.choice(cases)


def _no_number(rng: Random) -> Case:
    text = rng.choice(_NUMBERS)
    cases = (
        *_each("simulate", [("paper", f"--duration={text}"), ("planned", f"--plan-within={text}", *SHORT)]),
        *_each(rng.choice(("compare", "robustness")), [("paper", f"--jobs={text}")]),
        *_each(rng.choice(("reproduce", "missions")), [(f"--jobs={text}",)]),
        *_each("benchmark", [("paper", f"--peers-every={text}"), ("paper", "--peers-every=1.5")]),
        *(Case(("closed_loop", f"--depth={depth}"), script="show_diagram") for depth in (text, "1.5")),
    )
    return rng.choice(cases)


def _jobs(rng: Random) -> Case:
    script = rng.choice(("compare", "robustness", "reproduce", "missions"))
    named = ("paper",) if script in _FLYING else ()
    return Case((*named, "--jobs", rng.choice(_JOBS), *OUT), script=script)


def _duration(rng: Random) -> Case:
    text = rng.choice(_DURATIONS)
    if rng.random() < 0.3:
        return scenario_command(rng, "paper", (f"simulation.duration={text}",))
    return Case(("paper", f"--duration={text}", *OUT), script=rng.choice(_FLYING))


def _option(rng: Random) -> Case:
    lone = ("--fast", "-x", "--law", "--set", "--duration", "--jobs=2", "--quick", "--csv=yes", "paper")
    laws = ("x", "", "Level", "level ", "three axis", "zero")
    cases = (
        *_each("simulate", [("paper", option) for option in lone]),
        *_each("simulate", [("paper", "--law", law) for law in laws]),
        *_each("simulate", [("planned", f"--plan-within={text}", *SHORT) for text in ("-1", "nan", "-inf", "x")]),
        *_each(rng.choice(("compare", "robustness", "benchmark")), [("paper", "--law", "level"), ("paper", "--csv")]),
        *_each("reproduce", [("--slow",), ("paper",), ("--duration", "1")]),
        *_each("missions", [("nowhere",), ("--law", "level"), ("table_1", "x")]),
        *(Case(("paper", "--out", *more)) for more in ((), ("--csv",))),
        *(Case(command, script="show_diagram") for command in ((), ("x",), ("closed_loop", "--format", "bmp"))),
    )
    return rng.choice(cases)


def _at_odds(rng: Random) -> Case:
    law = ("--set", rng.choice(("attitude_law.name=level", "attitude_law.name=x", "attitude_law.name=three_axis")))
    disturbance = ("--set", rng.choice(("disturbance.mass_factor=2", "disturbance.x=1", "disturbance.noise_seed=0")))
    no_plan = ("planned", "--set", "mission.duration=2", "mission.radius=0.1", "airframe.rotor_speed_min=60")
    cases = (
        *_each("simulate", [("paper", "--law", law, "--plan-within", "3") for law in ("level", "pitch_only")]),
        *_each("simulate", [("planned", "--law", "level", "--plan-within", text) for text in ("-1", "nan", "0")]),
        *_each("simulate", [no_plan]),
        *_each("compare", [("paper", *law)]),
        *_each("robustness", [("paper", *law), ("paper", *disturbance), ("hover",)]),
        *_each("missions", [law]),
    )
    return rng.choice(cases)


def _override(rng: Random) -> Case:
    return scenario_command(rng, "paper", (rng.choice(_OVERRIDES),))


def _scenario_name(rng: Random) -> Case:
    return scenario_command(rng, rng.choice(_SCENARIOS))


def _out(rng: Random) -> Case:
    script = rng.choice((*_FLYING, "simulate", "reproduce", "missions"))
    named = ("paper", *SHORT) if script in _FLYING else ()
    place = rng.choice((*_PLACES, *(("file", "file/below/it", "link", "link/below", "loop", "loop/x") * 2)))
    links = {"link": rng.choice(("file", "/dev/null", "/proc/nowhere")), "loop": "loop"}
    files, links = (_FILE if place.startswith(("file", "link")) else {}), {n: links[n] for n in links if n in place}
    return Case((*named, f"--out={place}"), files, links, script=script)


def _file_out(rng: Random) -> Case:
    place = rng.choice(_FILE_PLACES)
    files, links = (_FILE if "file" in place else {}), ({"loop": "loop"} if place == "loop" else {})
    folders = ("folder",) if "folder" in place else ()
    if rng.random() < 0.5:
        return Case(("paper", *SHORT, *OUT, f"--json={place}"), files, links, folders, script="benchmark")
    return Case(("closed_loop", f"--out={place}"), files, links, folders, script="show_diagram")


def _odd_place(rng: Random) -> Case:
    """Where results can go after all, though the place is odd."""
    short = ("hover", *SHORT, "--set", "mpc.horizon=5")
    places = [(f"--out={place}",) for place in (*_ODD_PLACES, "link", "later")]
    repeated = [("--out", "first", "--out", "second"), (*OUT, "--set", "mpc.horizon=4", "mpc.horizon=6", "--csv"), ()]
    options = rng.choice([*places, *repeated])
    links = {name: target for name, target in (("link", "folder"), ("later", "nowhere")) if f"--out={name}" in options}
    return Case((*short, *options), links=links, folders=("folder",))


# What may be worked with: any good ending will do.
ODD_COMMANDS: dict[str, Callable[[Random], Case]] = {"odd place": _odd_place, "odd place for a file": _file_out}

BAD_COMMANDS: dict[str, Callable[[Random], Case]] = {
    "odd text": _text_somewhere,
    "no number": _no_number,
    "--jobs": _jobs,
    "--duration": _duration,
    "option": _option,
    "options at odds": _at_odds,
    "override": _override,
    "name of a scenario": _scenario_name,
    "--out": _out,
}
