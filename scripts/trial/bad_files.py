"""Bad files: what is named as a scenario's file and is none, or none that says one thing."""

from collections.abc import Callable, Sequence
from functools import partial
from random import Random

from scripts.trial.case import Case
from scripts.trial.commands import OUT, SHORT, scenario_command

_NO_UTF8 = (
    b"\xff\xfe\x00\x01",
    "mission:\n  radius: 2\n".encode("utf-16"),
    "# Höhe\nmission:\n  radius: 2\n".encode("latin-1"),
    b"mission:\n  radius: \xc3\x28\n",
    b"\xed\xa0\x80: 1\n",
    b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR",
)
_NO_YAML = (
    *("a: [", "a: {", "a: b: c", "mission:\n\tradius: 2", "'", '"', "[1, 2", "%YAML 9.9\n---\na: 1", "*nowhere"),
    *(
        "mission:\n  radius: 2\n radius: 3",
        "? [",
        "!<",
        "mission: {radius: 2",
        "a: |\nb",
        "\0",
        "a: \x07",
        "@x",
        "- - :",
    ),
    *("mission: !!python/tuple [1]", "!!x y: z", "\x1b[31m: 1", "!!python/name:os.system : 1", '"\\x"', "a: `b`"),
    *("mission: !!python/object/apply:os.system ['touch written']", "--- {link: {}}\n--- {mpc: {}}"),
)
_NO_MAP = (
    *("- mission", "mission", "3", "true", "[]", "''", "- 1\n- 2", "mission: 3", "mission: [1]", "mission: radius"),
    *("mission: ''", "mission: true", "mission: [radius, 2]", "mission:\n- radius: 2", "- mission: {radius: 2}"),
)
_TWICE = (
    "mission:\n  radius: 1\n  radius: 2\n",
    "mission:\n  radius: 1\nlink: {}\nmission:\n  radius: 2\n",
    "mission: {radius: 1, duration: 50, radius: 1}\n",
    "mission: {}\nmission: {}\n",
    "mission: {radius: 1, 'radius': 2}\n",
)
_KEYS = (
    *("1: 2", "null: 1", "true: {}", "~: {}", "[mission]: {}", "? {mission: 1}\n: {}", "2020-01-01: {}", "1.5: {}"),
    *("mission: {1: 2}", "mission: {null: 1}", "mission: {true: 1}", "mission: {[radius]: 1}", "mission: {'': 1}"),
    *("'': {radius: 1}", "mission: {? {a: 1} : 2}", "? |\n  mission\n  x\n: {radius: 1}", '"\\e[31m": {}', "<<: 3"),
)
_NAMES = (
    *("mission.radius: 2", "missions: {radius: 2}", "Mission: {radius: 2}", "mission: {Radius: 2}", "radius: 2"),
    *("mission: {radius: {value: 2}}", "mission: {radius.x: 2}", "paper: {mission: {radius: 2}}", "'mission ': {}"),
    *("mission: {__class__: 1}", "__init__: {}", "link: {wavelength: 1}", "ünïcödé: {a: 1}", "mission: {🚁: 1}"),
    *('"mission\\0": {}', 'mission: {"radius\\n": 2}', "mission:\n  radius: 2\n  speed: 1"),
)
_MISSING = (
    *("nowhere.yaml", "nowhere/scenario.yaml", "a/../b.yml", "x" * 300 + ".yaml", "x" * 5000 + ".yaml", ".yaml"),
    *("d/" * 150 + "x.yaml", "x/" * 3000 + "y.yml", "/dev/null/x.yaml", "ünïcödé.yaml", "\N{ZERO WIDTH SPACE}.yaml"),
    *("\udcff.yaml", "a\nb.yaml", "\x1b[31m.yaml", "a\0b.yaml"),
)


def _content(rng: Random, content: str | bytes) -> Case:
    encoded = content if isinstance(content, bytes) else content.encode()
    return scenario_command(rng, "scenario.yaml", (), {"scenario.yaml": encoded})


def _one_of(contents: Sequence[str] | Sequence[bytes], rng: Random) -> Case:
    return _content(rng, rng.choice(contents))


def _noise(rng: Random) -> Case:
    return _content(rng, b"\xff" + rng.randbytes(rng.choice((1, 30, 1000))))


def _deep(rng: Random) -> Case:
    depth = rng.choice((200, 2000, 20_000, 200_000))
    blocks = "".join(f"{' ' * i}a:\n" for i in range(min(depth, 2000)))
    return _one_of(("[" * depth + "]" * depth, "{a: " * depth + "1" + "}" * depth, "[" * depth, blocks), rng)


def _aliases(rng: Random) -> Case:
    """Text that grows by a factor a level, or that holds itself."""
    levels = range(1, rng.choice((5, 9, 30)))
    bomb = "a0: &a0 [1, 1]\n" + "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in levels)
    inside = f"{bomb}mission:\n  radius: *a{levels[-1]}\n"
    merged = "a0: &a0 {radius: 1}\n" + "".join(f"a{i}: &a{i} {{<<: [*a{i - 1}, *a{i - 1}]}}\n" for i in levels)
    itself = ("mission: &m {radius: *m}", "mission: &m [*m]", "&d mission: *d", "mission: {radius: &r [*r]}")
    return _one_of((bomb, inside, merged, rng.choice(itself)), rng)


def _long(rng: Random) -> Case:
    letters = "x" * rng.choice((300, 5000, 300_000))
    sections = "".join(f"k{i}: {{}}\n" for i in range(20_000))
    numbers = f"mission: {{radius: [{'1, ' * 20_000}1]}}"
    named = (f"{letters}: 1", f"mission: {{{letters}: 1}}", f"mission: {letters}", f"mission: {{radius: {letters}}}")
    return _one_of((*named, sections, numbers, letters), rng)


def _no_file(rng: Random) -> Case:
    return scenario_command(rng, rng.choice(_MISSING))


def _no_scenario_file(rng: Random) -> Case:
    targets = ("nowhere.yaml", "link.yaml", "/proc/self/mem", "/dev/zero")
    linked = [Case(("link.yaml", *SHORT, *OUT), links={"link.yaml": target}) for target in targets]
    named = [
        Case((name, *SHORT, *OUT), {name.partition("/")[0]: b"{}"}) for name in ("f.yaml/x.yaml", "f.txt", "f.YAML")
    ]
    folders = [Case((name, *SHORT, *OUT), folders=(name,)) for name in ("folder.yaml", "folder")]
    return rng.choice([*linked, *named, *folders, *(Case((name, *OUT)) for name in ("/dev/null", ".", "/"))])


BAD_FILES: dict[str, Callable[[Random], Case]] = {
    "no UTF-8": partial(_one_of, _NO_UTF8),
    "no YAML": partial(_one_of, _NO_YAML),
    "no map": partial(_one_of, _NO_MAP),
    "noise": _noise,
    "key given twice": partial(_one_of, _TWICE),
    "key that is no word": partial(_one_of, _KEYS),
    "unknown name in a file": partial(_one_of, _NAMES),
    "nested deep": _deep,
    "aliases": _aliases,
    "long": _long,
    "no file": _no_file,
    "no file of a scenario": _no_scenario_file,
}
