"""A benchmark's summary as text."""

from collections.abc import Iterable, Sequence

from a2s_drake.benchmark.summary import Summary
from a2s_drake.benchmark.timing import Statistics

_CASADI_SOLVERS = {
    "hpipm": "CasADi + HPIPM",
    "qpoases": "CasADi + qpOASES",
    "osqp": "CasADi + OSQP",
    "ipopt": "CasADi + IPOPT",
}
_STATISTICS = ("median", "p99", "p99_9", "max")


def benchmark_text(summary: Summary) -> str:
    """The tables of a summary, ready to print."""
    parts = [_flight(summary), _step(summary), _casadi(summary), _growth(summary)]
    return "\n\n".join(part for part in parts if part)


def _flight(summary: Summary) -> str:
    flight, memory, own = summary.flight, summary.peak_memory_mib, summary.own
    lines = [
        f"{flight.law} over {flight.duration_s:.2f} s, N = {flight.horizon}, QP by {flight.solver}: "
        f"{flight.real_time_factor:.1f} times real time, {flight.failures} solver failures",
        f"step: {summary.step_over_plain:.2f} times plain Drake + OSQP "
        f"({own.step_ms.median:.2f} ms against {summary.plain.step_ms.median:.2f} ms in the median)",
        f"applied input: at most {_percent(own.deviation_percent)} of the rotor range off the QP's solution to 1e-9, "
        f"over {own.problems - summary.without_exact_solution} of {own.problems} problems",
        f"peak memory: {memory.flight:.0f} MiB after the flight, {memory.benchmark:.0f} MiB after all of this",
    ]
    return "\n".join(lines)


def _step(summary: Summary) -> str:
    own, plain = summary.own, summary.plain
    rows = [["ms", "median", "p99", "p99.9", "max"]]
    rows.append(["controller block in flight", *_times(summary.flight.controller_ms)])
    rows.append(["step", *_times(own.step_ms)])
    rows += [[f"  {name.replace('_', ' ')}", *_times(times)] for name, times in own.split_ms.items()]
    rows.append(["plain Drake + OSQP", *_times(plain.step_ms)])
    rows += [[f"  {name}", *_times(times)] for name, times in plain.split_ms.items()]
    counts = [
        f"{name}: median {taken.median:.0f}, most {taken.max}"
        for name, taken in ((summary.flight.solver, own.iterations), ("plain", plain.iterations))
        if taken is not None
    ]
    off = f"applied input of plain: at most {_percent(plain.deviation_percent)} off"
    return f"{_table(rows)}\niterations: {'; '.join(counts)}\n{off}"


def _casadi(summary: Summary) -> str:
    if not summary.casadi:
        return ""
    header = [
        "CasADi on the same problems",
        "number",
        "median",
        "max",
        "ours",
        "ratio",
        "iterations",
        "off by",
        "failed",
    ]
    rows = [header]
    for name, other in summary.casadi.items():
        counted = f"{other.iterations.median:.0f}" if other.iterations else "-"
        times = [f"{getattr(other.time_ms, key):.2f} ms" for key in ("median", "max")]
        label, ours = f"{_CASADI_SOLVERS[name]}, {other.compared}", f"{other.own_median_ms:.2f} ms"
        ending = [counted, _percent(other.deviation_percent), str(other.failures)]
        rows.append([label, str(other.problems), *times, ours, f"{other.ratio:.2f}", *ending])
    notes = [
        "ratio: CasADi's median over ours. QP solve: from a program with its numbers updated to the solution, so all",
        "include reading the program; the linearisation before it is the same. IPOPT is set against a whole step: it",
        "solves the nonlinear program, where a step solves one QP; its deviation is what one iteration leaves.",
        "qpOASES starts from its last active set, and so gets four runs of five samples in a row.",
        "HPIPM of CasADi's wheel is built on BLASFEO's generic kernels; one built for this processor is faster.",
    ]
    return "\n".join([_table(rows), *notes])


def _growth(summary: Summary) -> str:
    growths = summary.growth
    horizons = next(iter(growths.values())).horizons
    rows = [["median step over N, ms", *map(str, horizons), "line", "R^2", "exponent"]]
    for solver, growth in growths.items():
        line = f"{growth.offset_ms:.2f} + {growth.per_stage_ms:.4f} N"
        cells = [*(f"{ms:.2f}" for ms in growth.median_ms), line]
        rows.append([solver, *cells, f"{growth.r_squared:.4f}", f"{growth.exponent:.2f}"])
        rows.append(["  iterations", *(f"{count:.0f}" for count in growth.iterations)])
    return _table(rows)


def _times(statistics: Statistics | None) -> list[str]:
    if statistics is None:
        return ["-"] * len(_STATISTICS)
    return [f"{getattr(statistics, key):.2f}" for key in _STATISTICS]


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{value:.1e} %"


def _table(rows: Iterable[Sequence[str]]) -> str:
    """Columns, the first to the left and the others to the right, with a rule under the first row."""
    lines = [list(row) for row in rows]
    full = [line for line in lines if len(line) == len(lines[0])]
    widths = [max(map(len, column)) for column in zip(*full, strict=True)]
    text = [
        "  ".join(cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(line, widths)))  # noqa: B905 - a line may be short
        for line in lines
    ]
    return "\n".join([text[0], "-" * len(text[0]), *text[1:]])
