"""Verdict: whether a case ended as it should, from its exit code, what it printed and what it wrote."""

import json
import math
import re
import unicodedata
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from a2s_drake import Flight, Scenario
from a2s_drake.flight.log import array_names, optional_names
from scripts.trial.case import Case
from scripts.trial.isolation import WORK, Ending

FLOWN, REFUSED, SENTENCE, FAULT = "flown", "refused", "ended in a sentence", "FAULT"

_LONGEST_LINE = 500

# What Drake, Python and the libraries say of themselves, and a person who types a scenario cannot read.
_FOREIGN = (
    *("Spatial force", "Traceback", "failed at", "condition", "pydrake", "drake::", "Errno", " object ", "abseil"),
    *("Quaternion", "DoCalc", "Simulator::", "LeafContext"),
    *("RuntimeError", "ValueError", "TypeError", "KeyError", "NoneType", "ndarray", "numpy", "std::", "bad_alloc"),
    *("codec", "unsupported operand", "not supported between", "could not convert", "surrogates", "unicode string"),
)
# How numpy and scipy open their warnings; ours have words of their own.
_FOREIGN_WARNING = ("encountered in", "Warning", "Mean of empty", "ill-conditioned", "lowercase", "deprecated")


class Fault(Exception):
    """An ending that should not be; says what is wrong with it."""


def judge(case: Case, ending: Ending, folder: Path) -> tuple[str, str]:
    """The kind of ending of a case that ran in a folder, and, for a fault, what is wrong."""
    try:
        return _kind(case, ending, folder / WORK), ""
    except Fault as fault:
        return FAULT, str(fault)


def _kind(case: Case, ending: Ending, work: Path) -> str:
    if ending.code is None:
        raise Fault(f"still running after {case.timeout:g} s")
    if ending.code < 0:
        raise Fault(f"ended by signal {-ending.code}")
    if "Traceback" in ending.stderr:
        raise Fault("a traceback")
    if ending.code == 0:
        _check_flown(case, ending, work)
        if case.must_refuse:
            raise Fault("accepted, and must be refused")
        return FLOWN
    if ending.code == 1:
        _check_sentence(ending, work)
        if case.must_refuse:
            raise Fault("exit 1, and must be refused with 2")
        return SENTENCE
    if ending.code == 2:
        _check_refused(case, ending)
        return REFUSED
    raise Fault(f"exit {ending.code}")


def _check_flown(case: Case, ending: Ending, work: Path) -> None:
    _check_warnings(_lines(ending.stderr))
    if re.search(r"\b(nan|inf)\b", ending.stdout, re.IGNORECASE):
        raise Fault("prints a number that is not finite")
    logs = list(work.rglob("flight.npz"))
    if case.path.stem == "simulate" and len(logs) != 1:
        raise Fault(f"exit 0 with {len(logs)} files flight.npz")
    for log in logs:
        samples = _check_log(log.parent)
        metrics = log.with_name("metrics.json")
        if not metrics.exists():
            raise Fault("a flight without metrics.json")
        check_metrics(metrics.read_text(encoding="utf-8"), samples)


def _check_sentence(ending: Ending, work: Path) -> None:
    *warned, last = _lines(ending.stderr) or [""]
    _check_warnings(warned)
    _check_error(last)
    logs = list(work.rglob("flight.npz"))
    if not logs:
        raise Fault("exit 1, and no samples are kept")
    for log in logs:
        _check_log(log.parent)


def _check_refused(case: Case, ending: Ending) -> None:
    lines = _lines(ending.stderr)
    if len(lines) != 1:
        raise Fault(f"exit 2 with {len(lines)} lines on stderr")
    _check_error(lines[0])
    if not any(name in lines[0] for name in _names(case)):
        raise Fault("the refusal names no field, option or file")
    if ending.stdout:
        raise Fault("refused, and printed on stdout")
    if ending.changed:
        raise Fault(f"refused, and wrote {', '.join(ending.changed[:5])}")


def _lines(text: str) -> list[str]:
    return text.removesuffix("\n").split("\n") if text else []


def _check_error(line: str) -> None:
    if not line.startswith("error: "):
        raise Fault("the last line on stderr does not start with 'error: '")
    if len(line) > _LONGEST_LINE:
        raise Fault(f"the error is {len(line)} characters long")
    if any(unicodedata.category(letter) in ("Cc", "Zl", "Zp") for letter in line):
        raise Fault("the error holds a control character")
    if foreign := [words for words in _FOREIGN if words in line]:
        raise Fault(f"the error is not in our words: {foreign[0]!r}")


def _check_warnings(lines: list[str]) -> None:
    for line in lines:
        if not line.startswith("warning: "):
            raise Fault("a line on stderr that is no warning of ours")
        if any(words in line for words in (*_FOREIGN, *_FOREIGN_WARNING)):
            raise Fault("a warning that is not in our words")


def _names(case: Case) -> Iterator[str]:
    """What a refusal may name: fields, options, files and whatever else was typed."""
    for section in fields(Scenario):
        yield section.name
    yield from ("--", "MISSION", "NAME", "unrecognized arguments", *case.files, *case.links, *case.folders)
    # A long name may be shown by its beginning.
    yield from (typed[:20] for text in case.arguments for typed in (text, repr(text)[1:-1]) if typed)


def _check_log(folder: Path) -> int:
    """The number of samples of a kept flight; raises Fault where it cannot be read or is not finite."""
    try:
        flight = Flight.load(folder)
    except (OSError, ValueError) as error:
        raise Fault(f"the flight cannot be loaded: {error}") from error
    for name in array_names():
        values = getattr(flight, name)
        if len(values) != len(flight.time) or not (name in optional_names() or np.isfinite(values).all()):
            raise Fault(f"flight.npz: {name} is not {len(flight.time)} finite rows")
    return len(flight.time)


def check_metrics(text: str, samples: int) -> None:
    """Raises Fault unless a text is strict JSON of finite numbers, null only where documented, on some samples."""
    try:
        metrics = json.loads(text, parse_constant=_refuse_constant)
    except ValueError as error:
        raise Fault(f"metrics.json is no strict JSON: {error}") from error
    for name, value in _leaves("", metrics):
        if value is None and _may_be_null(name, metrics):
            continue
        if value is None or (isinstance(value, float) and not math.isfinite(value)):
            raise Fault(f"metrics.json: {name} is {value}")
    if metrics["samples"] != samples:
        raise Fault(f"metrics.json: {metrics['samples']} samples, flight.npz has {samples}")


def _may_be_null(name: str, metrics: dict[str, Any]) -> bool:
    """Whether a value is unknown where it says so: there was no fade below this threshold, or no PIQP."""
    group, *path = name.split(".")
    return name == "versions.piqp" or (group == "fades" and metrics["fades"][path[0]]["count"] == 0)


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict | list):
        for key, entry in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _leaves(f"{name}.{key}" if name else str(key), entry)
    else:
        yield name, value
