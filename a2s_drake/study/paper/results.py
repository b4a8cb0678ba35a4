"""Results of the reproduction: every number of the report by name, and how they are written as JSON.

Gains are in percent of throughput. A field has the name of its key in results.json; `Results.as_json` lists the
exceptions.
"""

from dataclasses import asdict, dataclass
from typing import Any

from a2s_drake.study.ideal_tracking import IdealTracking
from a2s_drake.study.paper.attribution import Step
from a2s_drake.study.paper.errata import Erratum

# Metrics of a flight by name, as `flight.metrics` gives them, without what depends on the machine's clock.
Metrics = dict[str, Any]


@dataclass(frozen=True)
class PaperGains:
    """What the paper prints of the three-axis law: its gain over level and over pitch only, %."""

    over_level: float
    over_pitch_only: float


@dataclass(frozen=True)
class Gains:
    """What is flown: gains of the three-axis law over level and over pitch only, and of pitch only over level, %."""

    over_level: float
    over_pitch_only: float
    pitch_only_over_level: float


@dataclass(frozen=True)
class Claims:
    """What the paper says in words of its curves, in figures.

    Attributes:
      fades_below_0_db: how many there are, by law.
      outage_worst_excess: the most by which the outage of three axes exceeds the better benchmark's, as a share of
        the mission; below zero where it never does.
      outage_worst_excess_at_db: the SNR threshold where that is, dB.
    """

    fades_below_0_db: dict[str, int]
    outage_worst_excess: float
    outage_worst_excess_at_db: float


@dataclass(frozen=True)
class Headline:
    """The headline scenario as flown.

    Attributes:
      scenario: its name.
      gain_percent: of its flights.
      laws: metrics by law.
      claims: the paper's words in figures.
    """

    scenario: str
    gain_percent: Gains
    laws: dict[str, Metrics]
    claims: Claims


@dataclass(frozen=True)
class ReadingRow:
    """What one reading makes of the headline.

    Attributes:
      base: the name of the scenario that the reading changes.
      question: what the paper leaves open.
      answer: how this reading answers it.
      is_base: whether the base already reads so.
      over_level: as in `Gains`, and so are the next two.
      position_error_max_m: of the three-axis flight, m.
      solver_failures: over the three flights.
    """

    base: str
    question: str
    answer: str
    is_base: bool
    over_level: float
    over_pitch_only: float
    pitch_only_over_level: float
    position_error_max_m: float
    solver_failures: int


@dataclass(frozen=True)
class CeilingRow:
    """One way to choose the attitude.

    Attributes:
      name: in words.
      kind: `ceiling`, `held` (exactly, by the vehicle), `flown`, or `other` (held exactly, under another fallback).
        In results.json `held` is written `ideal`.
      law: empty for a ceiling, which is of no law.
      gain_percent: over level.
      share: of the gain of the best attitude in the box.
    """

    name: str
    kind: str
    law: str
    gain_percent: float
    share: float


@dataclass(frozen=True)
class PlannedGains:
    """Gains on Table I as printed, flown, %."""

    planned_over_level: float
    planned_over_three_axis: float
    three_axis_over_level: float


@dataclass(frozen=True)
class PlannedLaw:
    """The law `planned` beside the paper's.

    Attributes:
      scenario: the name of the scenario flown.
      gain_percent: of its flights.
      laws: metrics by law.
      attribution: what each effect costs either law, from the top.
    """

    scenario: str
    gain_percent: PlannedGains
    laws: dict[str, Metrics]
    attribution: list[Step]


@dataclass(frozen=True)
class Results:
    """All numbers of the report.

    Attributes:
      paper_gain_percent: what the paper prints.
      headline: the headline scenario as flown.
      ideal_tracking: what each law wins where the vehicle holds its reference exactly, by scenario. Its key in
        results.json is `ideal`.
      ceilings: each way to choose the attitude, by scenario.
      errata: the slips of the paper's text.
      versions: of what computed these numbers, by package.
      readings: what each reading makes of the headline; None in a quick report.
      planned: the law `planned`; None in a quick report. Its key in results.json is `beyond`.
    """

    paper_gain_percent: PaperGains
    headline: Headline
    ideal_tracking: dict[str, IdealTracking]
    ceilings: dict[str, list[CeilingRow]]
    errata: list[Erratum]
    versions: dict[str, str]
    readings: list[ReadingRow] | None = None
    planned: PlannedLaw | None = None

    def as_json(self) -> dict[str, Any]:
        """What results.json holds: these fields as dictionaries, without those that are None."""
        # The file keeps the words of its first version, so that what reads it need not change.
        keys = {"planned": "beyond", "ideal_tracking": "ideal"}
        entries = {keys.get(name, name): value for name, value in asdict(self).items() if value is not None}
        for row in (row for rows in entries["ceilings"].values() for row in rows):
            row["kind"] = "ideal" if row["kind"] == "held" else row["kind"]
        return entries
