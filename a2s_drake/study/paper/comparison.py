"""Comparison: laws side by side, as text, beside what the paper prints of its three."""

from collections.abc import Mapping

from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import compute_metrics, gain_percent
from a2s_drake.scenario.parts import Mission

# Gain in throughput that the paper prints (abstract and section V), %: (law, baseline) -> gain.
PAPER_GAINS = {("three_axis", "level"): 22.2, ("three_axis", "pitch_only"): 11.4}

_HEADER = (
    ("", "throughput", "over level", "", "over pitch only", "", "position", "solver", "MPC step", "wall", "times"),
    ("law", "bit/Hz", "here", "paper", "here", "paper", "error max", "failures", "median", "clock", "real time"),
)


def _gains(flights: Mapping[str, Flight], law: str, baseline: str) -> list[str]:
    here = "-" if law == baseline else f"{gain_percent(flights[law], flights[baseline]):+.2f} %"
    # The paper's figures belong to its own mission flown to the end.
    scenario = flights[law].scenario
    comparable = scenario.mission == Mission() and scenario.duration == Mission().duration
    paper = PAPER_GAINS.get((law, baseline)) if comparable else None
    return [here, "-" if paper is None else f"+{paper} %"]


def comparison_table(flights: Mapping[str, Flight]) -> str:
    """A table of flights by law, which must hold `level` and `pitch_only`, flown just now (their clocks are read)."""
    rows = [list(line) for line in _HEADER]
    for law, flight in flights.items():
        metrics = compute_metrics(flight)
        step = metrics["solver"]["step_ms"]
        rows.append(
            [
                law,
                f"{metrics['throughput_bit_per_hz']:.3f}",
                *_gains(flights, law, "level"),
                *_gains(flights, law, "pitch_only"),
                f"{100 * metrics['position_error_max_m']:.2f} cm",
                str(metrics["solver"]["failures"]) if metrics["solver"]["present"] else "-",
                f"{step['median']:.1f} ms" if step else "-",
                f"{metrics['wall_s']:.1f} s",
                f"{metrics['real_time_factor']:.1f}",
            ]
        )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join(
            cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    ]
    lines.insert(len(_HEADER), "-" * len(lines[0]))
    return "\n".join(line.rstrip() for line in lines)
