"""Random scenarios: a named scenario with some fields drawn anew over the ranges that the parts declare."""

import math
from dataclasses import Field, fields
from functools import cache
from random import Random
from typing import Any

from a2s_drake import Scenario
from a2s_drake.scenario.parts import PAPER_LAWS
from diagrams import load_scenario
from scripts.trial.case import Case

_BASES = ("paper", "paper_calibrated", "hover", "tilt35")
# Every 25th case plans. Of 21 others one flies OSQP and one IPOPT, now as a file and now as overrides.
_PLANS_EVERY = 25
_SOLVER_EVERY, _OTHER_SOLVERS = 21, {3: "osqp", 16: "ipopt"}
# Every third case changes only what a flight can end early by, flies longer, and mostly spins too easily for the step.
_ROUGH_EVERY, _ROUGH = 3, ("airframe.", "mpc.", "disturbance.")
# A case that would merely be long is drawn again. The estimate is rough, s on one core.
_LONGEST = 4.0
# The smallest magnitude drawn from a range that reaches down to zero.
_TINY = 1e-9

Values = dict[str, Any]


def scenario_case(seed: int, number: int) -> Case:
    """The random scenario of a number, half of them as a file and half as overrides of a named one."""
    rng = Random(f"scenario {seed} {number}")
    plans = number % _PLANS_EVERY == _PLANS_EVERY - 1
    base = "planned" if plans else rng.choice(_BASES)
    defaults = _base_values(base)
    while True:
        drawn = _planned(rng, defaults) if plans else _flown(rng, defaults, number)
        if _seconds(defaults | drawn) <= _LONGEST:
            break
    law, solver = ((defaults | drawn)[name] for name in ("attitude_law.name", "mpc.solver"))
    if number % 2:
        named = {name: value for name, value in defaults.items() if value != _DEFAULTS[name]}
        command, files = ["scenario.yaml"], {"scenario.yaml": yaml_file(named | drawn).encode()}
    else:
        command, files = [base, "--set", *(f"{name}={yaml_text(value)}" for name, value in drawn.items())], {}
    command += ["--out", "out", *(["--csv"] if rng.random() < 0.1 else [])]
    command += ["--plan-within", "5"] if plans and rng.random() < 0.5 else []
    return Case(
        tuple(command),
        files,
        kind=f"scenario, {law}",
        timeout=60.0 if law != "planned" and solver != "ipopt" else 300.0,
    )


def _values(scenario: Scenario) -> Values:
    sections = [section.name for section in fields(scenario)]
    parts = {section: getattr(scenario, section) for section in sections}
    return {f"{name}.{entry.name}": getattr(part, entry.name) for name, part in parts.items() for entry in fields(part)}


@cache
def _base_values(name: str) -> Values:
    return _values(load_scenario(name))


_DEFAULTS = _values(Scenario())
FIELDS: dict[str, Field[Any]] = {
    f"{section.name}.{entry.name}": entry
    for section in fields(Scenario)
    for entry in fields(section.default_factory)  # type: ignore[arg-type]
}


def _flown(rng: Random, defaults: Values, number: int) -> Values:
    """One to six fields of a flight under a law that makes no plan."""
    rough = number % _ROUGH_EVERY == 0
    drawn: Values = {"simulation.duration": round(rng.uniform(0.2, 2.0 if rough else 1.0), 2)}
    if number % _SOLVER_EVERY in _OTHER_SOLVERS:
        drawn["mpc.solver"] = _OTHER_SOLVERS[number % _SOLVER_EVERY]
    names = [name for name in FIELDS if name != "mpc.solver" and not name.startswith("planning.")]
    if rough:
        names = [name for name in names if name.startswith(_ROUGH)]
        if rng.random() < 0.7:
            drawn["disturbance.inertia_factor"] = 10.0 ** rng.uniform(-2.0, -0.7)
            drawn["simulation.max_step_size"] = 10.0 ** rng.uniform(-2.0, 0.0)
            names = [name for name in names if name not in drawn]
    if drawn.get("mpc.solver") == "ipopt":  # which may take 300 iterations a sample, each as long as its horizon
        drawn["mpc.horizon"] = rng.randint(1, 8)
        drawn["simulation.duration"] = round(rng.uniform(0.1, 0.3), 2)
        names = [name for name in names if name not in drawn]
    for name in rng.sample(names, rng.randint(1, 6)):
        drawn[name] = rng.choice(PAPER_LAWS) if name == "attitude_law.name" else draw(rng, FIELDS[name], defaults[name])
    if not {"attitude_law.name", "mpc.solver"} & drawn.keys():
        drawn["attitude_law.name"] = rng.choice(PAPER_LAWS)
    return drawn


def _planned(rng: Random, defaults: Values) -> Values:
    """A mission that is planned in seconds, with one to three fields drawn, mostly of the planning."""
    duration = rng.uniform(1.0, 4.0)
    drawn: Values = {"mission.duration": duration, "mission.radius": rng.uniform(0.0, 0.05) * duration}
    drawn["simulation.duration"] = round(rng.uniform(0.2, 1.0), 2)
    names = [name for name in FIELDS if name not in (*drawn, "attitude_law.name", "mpc.solver")]
    planning = [name for name in names if name.startswith("planning.")]
    for _ in range(rng.randint(1, 3)):
        name = rng.choice(planning if rng.random() < 0.6 else names)
        drawn[name] = draw(rng, FIELDS[name], defaults[name])
    return drawn


def draw(rng: Random, field: Field[Any], default: Any) -> Any:
    """A value of a field's range: close to its default, anywhere by magnitude, or an exact end."""
    limits = dict(field.metadata)
    if "choices" in limits:
        return rng.choice(limits["choices"])
    if "file" in limits:  # There is none to draw.
        return default
    if "length" not in limits:
        return _number(rng, limits, default)
    if rng.random() < 0.5:
        return [_number(rng, limits, entry) for entry in default]
    place = rng.randrange(len(default))
    return [_number(rng, limits, entry) if i == place else entry for i, entry in enumerate(default)]


def ends(limits: dict[str, Any], *, whole: bool) -> tuple[float, float]:
    """The lowest and the highest value that a field may have."""
    low, high = limits.get("at_least"), limits.get("at_most")
    if low is None:
        low = limits["above"] + 1 if whole else math.nextafter(limits["above"], math.inf)
    if high is None:
        high = limits["below"] - 1 if whole else math.nextafter(limits["below"], -math.inf)
    return low, high


def _number(rng: Random, limits: dict[str, Any], default: float | int | None) -> float | int:
    whole = isinstance(default, int)
    low, high = ends(limits, whole=whole)
    choice = rng.random()
    if choice < 0.15:
        return rng.choice((low, high))
    if choice < 0.6 and default:
        value = default * 2.0 ** rng.uniform(-1.0, 1.0)
    else:
        smallest = low if low > 0.0 else 1.0 if whole else _TINY
        value = math.exp(rng.uniform(math.log(smallest), math.log(max(high, -low))))
        value *= rng.choice((-1.0, 1.0)) if low < 0.0 else 1.0
    value = min(max(value, low), high)
    return round(value) if whole else value


def _seconds(values: Values) -> float:
    """About how long the checks and the flight take."""
    period, mission = values["mpc.period"], values["mission.duration"]
    flight = mission if values["simulation.duration"] is None else values["simulation.duration"]
    samples, horizon = flight / period + 1.0, values["mpc.horizon"]
    fringes = values["attitude_law.index_max"] - values["attitude_law.index_min"]
    per_node = {"piqp": 2e-4, "osqp": 1e-3, "ipopt": 3e-2}[values["mpc.solver"]] + 1e-7 * max(fringes, 0)
    # One sample in which OSQP finds no solution may take all the iterations there are, several times over.
    worst = 2e-5 * horizon * values["mpc.qp_max_iterations"] if values["mpc.solver"] == "osqp" else 0.0
    steps = flight / min(values["simulation.max_step_size"], period)
    return 2e-6 * mission / period + samples * (2e-3 + per_node * horizon) + worst + 2e-4 * steps


def yaml_text(value: Any) -> str:
    """A value as one line of YAML."""
    if isinstance(value, list):
        return f"[{', '.join(map(yaml_text, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return "null" if value is None else str(value)


def yaml_file(values: Values) -> str:
    """Values by `section.field` as a scenario file."""
    sections: dict[str, list[str]] = {}
    for name, value in values.items():
        section, _, key = name.partition(".")
        sections.setdefault(section, []).append(f"  {key}: {yaml_text(value)}\n")
    return "".join(f"{section}:\n{''.join(lines)}" for section, lines in sections.items())
