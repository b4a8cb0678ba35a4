"""Bad values: scenarios with a field, or a pair of fields, that no flight can have."""

import math
from collections.abc import Callable
from random import Random

from scripts.trial.case import Case
from scripts.trial.commands import scenario_command, setting_command
from scripts.trial.scenarios import FIELDS, ends, yaml_text

_NUMBERS = [name for name, field in FIELDS.items() if {"at_least", "above"} & set(field.metadata)]
_LISTS = [name for name, field in FIELDS.items() if "length" in field.metadata]
_SCALARS = [name for name in _NUMBERS if name not in _LISTS]
_CHOICES = [name for name, field in FIELDS.items() if isinstance(field.default, str)]

# Not a number, not a list of numbers, not a truth value and not the word of any choice.
_WRONG = (
    *("heavy", "''", '""', "' '", "[]", "[[]]", "{}", "{a: 1}", "2020-01-01", "1.2.3", "1,5", "1 kg", "~x"),
    *("[a, b, c]", "[1, [2], 3]", "[null]", "[null, null, null]", "[true, 1, x]", "!!binary aGk=", "!!set {a, b}"),
    *("ünïcödé", "Ⅻ", "٣x", "🚁", "\N{RIGHT-TO-LEFT OVERRIDE}abc", "\N{ZERO WIDTH SPACE}", "'%s%n'", "'{0.x}'"),
    *('"\\e[31mred\\e[0m"', '"\\a"', '"a\\nb"', '"a\\rb"', '"\\0"', '"\\t"', '"\\x7f"', '"\\L"', "'a\\b'"),
)
_NOT_FINITE = (".nan", ".NaN", ".inf", "-.inf", "+.inf", "nan", "inf", "-inf", "NaN", "Infinity", "1e999", "-1e999")
_HUGE = ("1e308", "-1e308", "1" + "0" * 400, "-1" + "0" * 30, "9" * 19, "9" * 20, "0x" + "f" * 40, "1e" + "9" * 20)

# Fields that are each sound and together are not.
_TOGETHER = (
    ("airframe.rotor_speed_min=60", "airframe.rotor_speed_max=60"),
    ("airframe.rotor_speed_min=70", "airframe.rotor_speed_max=60"),
    ("airframe.inertia=[1, 1, 3]",),
    ("airframe.inertia=[1e-6, 1e-6, 1e5]",),
    ("airframe.mass=1e4",),
    ("airframe.thrust_coefficient=1e-9",),
    ("airframe.tilt_deg=89.99999999999999",),
    ("attitude_law.index_min=10", "attitude_law.index_max=9"),
    ("attitude_law.index_min=-100000", "attitude_law.index_max=-100000", "attitude_law.name=pitch_only"),
    ("mpc.position_lower=[0, 0, 0]", "mpc.position_upper=[0, 1, 1]"),
    ("mpc.position_lower=[-1e5, -1e5, 1]", "mpc.position_upper=[1e5, 1e5, 2]"),
    ("disturbance.gust_duration=2", "disturbance.gust_interval=1.9999999999999998"),
    ("mission.duration=0.001", "mission.radius=0"),
    ("mission.duration=39", "mpc.velocity_limit=0.001"),
    ("mission.start=[0, 0, -20]",),
    ("mission.start=[0, 0, -20.00000001]",),
    ("link.antenna_offset=[0, 0, -20.1]",),
    ("mpc.period=1e-4", "mission.duration=86400"),
    ("mpc.period=10", "mission.duration=9.99", "mission.radius=0"),
    ("mission.radius=1e4",),
    ("attitude_law.name=planned", "mission.duration=2", "mission.radius=0.1", "airframe.rotor_speed_min=60"),
)


def _out_by_one(rng: Random) -> Case:
    name, low, high, whole = _range(rng)
    below = low - 1 if whole else math.nextafter(low, -math.inf)
    above = high + 1 if whole else math.nextafter(high, math.inf)
    return _number_set(rng, name, rng.choice((below, above)))


def _far_out(rng: Random) -> Case:
    name, low, high, whole = _range(rng)
    excess = 10.0 ** rng.uniform(0.0, 15.0) * max(1.0, abs(low), abs(high))
    value = rng.choice((low - excess, high + excess))
    return _number_set(rng, name, round(value) if whole else value)


def _range(rng: Random) -> tuple[str, float, float, bool]:
    name = rng.choice(_NUMBERS)
    whole = isinstance(FIELDS[name].default, int)
    return name, *ends(dict(FIELDS[name].metadata), whole=whole), whole


def _number_set(rng: Random, name: str, value: float) -> Case:
    return _text_set(rng, name, yaml_text(value))


def _text_set(rng: Random, name: str, text: str) -> Case:
    """A number set to a text; in a list, one entry of it."""
    if name not in _LISTS:
        return setting_command(rng, name, text)
    entries = [yaml_text(entry) for entry in FIELDS[name].default_factory()]  # type: ignore[misc, operator]
    entries[rng.randrange(len(entries))] = text
    return setting_command(rng, name, f"[{', '.join(entries)}]")


def _not_finite(rng: Random) -> Case:
    return _text_set(rng, rng.choice(_NUMBERS), rng.choice(_NOT_FINITE))


def _huge_number(rng: Random) -> Case:
    return _text_set(rng, rng.choice(_NUMBERS), rng.choice(_HUGE))


def _wrong_type(rng: Random) -> Case:
    return setting_command(rng, rng.choice(list(FIELDS)), rng.choice(_WRONG))


def _half_of_a_whole(rng: Random) -> Case:
    wholes = [name for name in _SCALARS if isinstance(FIELDS[name].default, int)]
    return setting_command(rng, rng.choice(wholes), rng.choice(("1.5", "2.0000001", "-0.5", "1e-3")))


def _no_choice(rng: Random) -> Case:
    name = rng.choice(_CHOICES)
    choice = rng.choice(FIELDS[name].metadata["choices"])
    return setting_command(
        rng, name, rng.choice((choice.upper(), f"'{choice} '", f"{choice}x", f"[{choice}]", "1", "no", "''"))
    )


def _nothing(rng: Random) -> Case:
    names = [name for name in FIELDS if FIELDS[name].default is not None]
    return setting_command(rng, rng.choice(names), rng.choice(("", "null", "~")))


def _wrong_length(rng: Random) -> Case:
    name = rng.choice(_LISTS)
    length = FIELDS[name].metadata["length"]
    many = rng.choice([n for n in (0, 1, length - 1, length + 1, 7, 300, 20_000) if n != length])
    text = f"[{', '.join(['0.5'] * many)}]"
    if many > 300:  # longer than an argument may be
        section, _, field = name.partition(".")
        return scenario_command(rng, "long.yaml", (), {"long.yaml": f"{section}:\n  {field}: {text}\n".encode()})
    return setting_command(rng, name, text)


def _list_of_one(rng: Random) -> Case:
    name = rng.choice(_SCALARS + _LISTS)
    value = FIELDS[name].default
    return setting_command(rng, name, f"[{value}]" if name in _SCALARS else "0.5")


def _together(rng: Random) -> Case:
    overrides = rng.choice(_TOGETHER)
    return Case(("paper", "--set", *overrides, "--out", "out"))


BAD_VALUES: dict[str, Callable[[Random], Case]] = {
    "out of range by one": _out_by_one,
    "far out of range": _far_out,
    "not finite": _not_finite,
    "huge number": _huge_number,
    "wrong type": _wrong_type,
    "no whole number": _half_of_a_whole,
    "no choice": _no_choice,
    "nothing": _nothing,
    "list of wrong length": _wrong_length,
    "list for a number": _list_of_one,
    "fields at odds": _together,
}
