"""Scenario: all that a flight depends on, as one object. YAML holds it, overrides change it, `validate` checks it."""

import copy
import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Self, get_type_hints

import numpy as np
from pydrake.common.yaml import yaml_dump_typed

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.quoting import PATH_LENGTH, named, one_line, quoted, shorten
from a2s_drake.scenario.checks import ScenarioError, check_inertia, check_order, check_part, refuse
from a2s_drake.scenario.field_values import field_value
from a2s_drake.scenario.parts import (
    Airframe,
    AttitudeLaw,
    Disturbance,
    Knowledge,
    Link,
    Mission,
    Mpc,
    Planning,
    Simulation,
)
from a2s_drake.scenario.yaml_reader import YamlMap, read_text, read_yaml

# More samples than this in one flight is a slip of the keyboard: at 20 ms it is more than two days.
_MAX_SAMPLES = 10_000_000


@dataclass
class Scenario:
    """One flight: all that it depends on, section by section; Table I (`paper`) by default."""

    airframe: Airframe = field(default_factory=Airframe)
    link: Link = field(default_factory=Link)
    mission: Mission = field(default_factory=Mission)
    attitude_law: AttitudeLaw = field(default_factory=AttitudeLaw)
    planning: Planning = field(default_factory=Planning)
    mpc: Mpc = field(default_factory=Mpc)
    disturbance: Disturbance = field(default_factory=Disturbance)
    knowledge: Knowledge = field(default_factory=Knowledge)
    simulation: Simulation = field(default_factory=Simulation)

    @property
    def duration(self) -> float:
        """Length of the flight, s: `simulation.duration`, or the mission's where that is null."""
        return self.mission.duration if self.simulation.duration is None else self.simulation.duration

    def true_link(self) -> Link:
        """The link as it truly is: the believed one with the errors of antenna height and transmit power."""
        return replace(
            self.link,
            ship_antenna_height=self.link.ship_antenna_height + self.knowledge.ship_antenna_height_error,
            transmit_power_dbm=self.link.transmit_power_dbm + self.knowledge.transmit_power_error_db,
        )

    def sample_times(self) -> FloatArray:
        """The controller's sampling instants t_k = k T_s from 0 to the end of the flight, s, shape (n,)."""
        return self.samples_until(self.duration)

    def samples_until(self, end: float) -> FloatArray:
        """The controller's sampling instants from 0 to an end, s, shape (n,)."""
        return self.mpc.period * np.arange(self._count_until(end), dtype=np.float64)

    def _count_until(self, end: float) -> int:
        # The tolerance keeps the last sample of a duration that is a multiple of T_s but for rounding.
        return int(end / self.mpc.period + 1e-9) + 1

    @classmethod
    def from_yaml(cls, text: str, *, name: str | None = None, source: str = "YAML", folder: Path | None = None) -> Self:
        """A scenario from YAML; fields that the text leaves out keep their defaults. Does not validate.

        Args:
          text: a document that holds one scenario, or, with `name`, a map of scenarios by name.
          source: what to call the text in errors.
          folder: what the relative names of files in the text are relative to; the working directory without it.
        Raises:
          ScenarioError: when it is no YAML, or names an unknown scenario or field, or a value has the wrong type. It
            names the source and the line.
        """
        document, place = read_yaml(text, source), source
        if name is not None:
            if not isinstance(document, YamlMap) or name not in document:
                known = ", ".join(map(named, document)) if isinstance(document, YamlMap) else "none"
                raise ScenarioError(f"{source}: no scenario named {quoted(name)}; there are: {shorten(known, 300)}")
            place = f"{source}, line {document.lines[name]}"
            document = document[name]
        scenario = cls()
        try:
            for section, settings, line in _entries(document, "a scenario"):
                place = f"{source}, line {line}"
                scenario._part(section, section)
                for key, value, line_of_key in _entries(settings, section):
                    place = f"{source}, line {line_of_key}"
                    scenario._set(section, key, value)
        except ScenarioError as error:
            raise ScenarioError(f"{place}: {error}") from error
        return scenario if folder is None else scenario._with_files(lambda file: str(folder / file))

    @classmethod
    def load(cls, path: Path | str) -> Self:
        """A scenario from a YAML file, which the names of files in it are relative to. Does not validate.

        Raises:
          OSError: when the file cannot be read; ScenarioError, which names it: when it does not hold a scenario.
        """
        path = Path(path)
        return cls.from_yaml(read_text(path), source=one_line(str(path), PATH_LENGTH), folder=path.parent)

    def to_yaml(self) -> str:
        """Every field as YAML; `from_yaml` of it equals this scenario exactly."""
        return str(yaml_dump_typed(self))

    def save(self, path: Path) -> None:
        """Writes this scenario as a YAML file that `load` reads back; it names the same files as this scenario."""
        told = self._with_files(lambda file: file if Path(file).is_absolute() else os.path.relpath(file, path.parent))
        path.write_text(told.to_yaml(), encoding="utf-8")

    def _with_files(self, rename: Callable[[str], str]) -> Self:
        """A copy whose fields that name a file name another one."""
        changed = copy.deepcopy(self)
        for section in fields(changed):
            part = getattr(changed, section.name)
            for entry in fields(part):
                if "file" in entry.metadata and getattr(part, entry.name):
                    setattr(part, entry.name, rename(getattr(part, entry.name)))
        return changed

    def with_value(self, name: str, value: Any) -> Self:
        """A copy with one field, named `section.field`, set to a value as YAML would hold it. Does not validate.

        Raises:
          ScenarioError: for an unknown field or a value of the wrong type.
        """
        section, _, key = name.partition(".")
        changed = copy.deepcopy(self)
        changed._set(section, key, value)
        return changed

    def with_overrides(self, overrides: Iterable[str]) -> Self:
        """A copy with fields set from texts `section.field=value`, the value in YAML. Does not validate.

        Raises:
          ScenarioError: for a text of another form, an unknown field or a value of the wrong type.
        """
        scenario = self
        for text in overrides:
            name, value = parse_override(text)
            scenario = scenario.with_value(name, read_yaml(value, quoted(text)))
        return scenario

    def _part(self, section: str, asked: str) -> Any:
        sections = [entry.name for entry in fields(self)]
        if section not in sections:
            raise ScenarioError(f"{named(asked)}: no such section; there are: {', '.join(sections)}")
        return getattr(self, section)

    def _set(self, section: str, key: str, value: Any) -> None:
        name = f"{section}.{key}" if key else section
        part = self._part(section, name)
        kinds = get_type_hints(type(part))
        if key not in kinds:
            raise ScenarioError(f"{named(name)}: no such field; {section} has: {', '.join(kinds)}")
        setattr(part, key, field_value(name, value, kinds[key]))

    def validate(self) -> Self:
        """Checks every field against its range, and fields against each other; returns this scenario, to chain calls.

        Whether the vehicle can fly it is a question of physics, which `a2s_drake.flight.feasible.check` answers.

        Raises:
          ScenarioError: names the first field that stands in the way, its value and what is allowed.
        """
        for section in fields(self):
            check_part(section.name, getattr(self, section.name))
        check_inertia(self.airframe)
        check_order("airframe", self.airframe, "rotor_speed_min", "rotor_speed_max")
        check_order("attitude_law", self.attitude_law, "index_min", "index_max", strict=False)
        check_order("mpc", self.mpc, "position_lower", "position_upper")
        check_order("disturbance", self.disturbance, "gust_duration", "gust_interval", strict=False)
        self._check_sampling()
        return self

    def _check_sampling(self) -> None:
        period = self.mpc.period
        if self.duration < period:
            name = "mission.duration" if self.simulation.duration is None else "simulation.duration"
            raise refuse(name, self.duration, f"must be at least one period, mpc.period = {period!r} s")
        if self._count_until(max(self.duration, self.mission.duration)) > _MAX_SAMPLES:
            raise refuse("mpc.period", period, f"must give at most {_MAX_SAMPLES} samples over the flight's duration")


def parse_override(text: str) -> tuple[str, str]:
    """The name of the field and the text of the value in `section.field=value`, without blanks around the name.

    Raises:
      ScenarioError: for a text of another form.
    """
    name, equals, value = text.partition("=")
    if not equals:
        raise ScenarioError(f"{quoted(text)}: an override has the form section.field=value")
    return name.strip(), value


def _entries(document: Any, what: str) -> Iterator[tuple[str, Any, int]]:
    """The keys and values of a map, and the line of each; none where there is nothing."""
    if document is None:  # as YAML reads a key with nothing behind it
        return
    if not isinstance(document, YamlMap):
        raise ScenarioError(f"{what} must be a map of settings, is {quoted(document)}")
    for key, value in document.items():
        yield key, value, document.lines[key]
