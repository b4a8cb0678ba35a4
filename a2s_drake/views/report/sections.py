"""The report's sections: tables of the reproduction's numbers."""

from collections.abc import Mapping, Sequence

from a2s_drake.flight.metrics import OUTAGE_THRESHOLDS_DB
from a2s_drake.guidance.laws import LAW_LABELS
from a2s_drake.scenario.parts import PAPER_LAWS
from a2s_drake.study.paper.results import Metrics, PlannedLaw, ReadingRow, Results
from a2s_drake.views.report.html import table


def _fares(caption: str, laws: Mapping[str, Metrics]) -> str:
    """How each law fares in closed loop, from metrics by law."""
    head = ["law", "throughput (bit/Hz)", *(f"outage {t:g} dB" for t in OUTAGE_THRESHOLDS_DB)]
    head += ["position error max (cm)", "rms (cm)", "attitude error rms, roll pitch yaw (deg)", "solver failures"]
    fares = []
    for law, entry in laws.items():
        errors = ", ".join(f"{value:.2f}" for value in entry["attitude_error_rms_deg"])
        fares.append(
            [
                LAW_LABELS[law],
                f"{entry['throughput_bit_per_hz']:.3f}",
                *(f"{100 * share:.1f} %" for share in entry["outage"].values()),
                f"{100 * entry['position_error_max_m']:.1f}",
                f"{100 * entry['position_error_rms_m']:.1f}",
                errors,
                str(entry["solver"]["failures"]),
            ]
        )
    return table(caption, head, fares)


def _uses(laws: Mapping[str, Metrics]) -> str:
    uses = [
        [name.replace("_", " "), *(f"{100 * entry['bounds'][name]['largest_use']:.0f} %" for entry in laws.values())]
        for name in laws["level"]["bounds"]
    ]
    head = ["", *(LAW_LABELS[law] for law in laws)]
    return table("Largest use of each bound (0 % mid-range, 100 % bound)", head, uses)


def against(results: Results) -> str:
    """What the paper prints of its headline against what is flown here."""
    gains, paper = results.headline.gain_percent, results.paper_gain_percent
    laws = results.headline.laws
    rows = [
        ["three axes over level", f"+{paper.over_level} %", f"{gains.over_level:+.2f} %"],
        ["three axes over pitch only", f"+{paper.over_pitch_only} %", f"{gains.over_pitch_only:+.2f} %"],
    ]
    return "\n".join(
        [
            '<div class="tables">',
            table("Throughput, paper against here", ["gain of", "paper", "here"], rows),
            _uses(laws),
            "</div>",
            _fares("The three laws in closed loop (the paper shows these as curves, without figures)", laws),
        ]
    )


def planned_law(planned: PlannedLaw, figures: str) -> list[str]:
    """The section on the law `planned`."""
    gains = planned.gain_percent
    steps = [
        [
            LAW_LABELS[step.law],
            step.effect,
            step.attitude,
            f"{step.gain_percent:+.2f} %",
            f"{0.0 + round(-step.cost, 2):+.2f}" if step.effect else "",
            "" if not step.effect or step.share is None else f"{100 * step.share:.1f} %",
        ]
        for step in planned.attribution
    ]
    head = ["law", "effect", "attitude", "over level", "cost (points)", "share of the above"]
    return [
        "<h2>Beyond the paper: a planned attitude</h2>",
        f"<p>The law <code>planned</code> chooses the whole attitude before take-off, on the exact channel and within "
        "what rotors, rates and angles allow. The controller, with the paper's weights, follows it. On Table I as "
        f"printed it wins {gains.planned_over_level:+.2f} % over level as flown and "
        f"{gains.planned_over_three_axis:+.2f} % over the paper's law. That law wins "
        f"{gains.three_axis_over_level:+.2f} % over level.</p>",
        _fares("Table I as printed, in closed loop", planned.laws),
        _uses(planned.laws),
        "<p>The table shows what each effect costs, in the order in which a law is made and flown. In another order "
        "the costs would be others. Attitudes are held exactly and compared with level held exactly. Only the last "
        "line of each law compares flights. There, level is helped by the height at which the paper's weights let it "
        "hang.</p>",
        table("From the best attitude down to what is flown", head, steps, text=3),
        figures,
    ]


def reading_table(readings: Sequence[ReadingRow]) -> str:
    """What each reading makes of the headline."""
    rows, bold = [], []
    home = {row.base: row for row in readings if row.is_base}
    for index, row in enumerate(readings):
        moved = row.over_level - home[row.base].over_level
        if row.is_base:
            bold.append(index)
        rows.append(
            [
                row.base,
                row.question,
                row.answer + (" (base)" if row.is_base else ""),
                f"{row.over_level:+.2f}",
                f"{moved:+.2f}",
                f"{row.over_pitch_only:+.2f}",
                f"{100 * row.position_error_max_m:.1f}",
                str(row.solver_failures),
            ]
        )
    head = [
        "from",
        "question",
        "reading",
        "over level (%)",
        "moved by",
        "over pitch only (%)",
        "error max (cm)",
        "failures",
    ]
    return table("Each reading in closed loop: gain of three axes", head, rows, text=3, bold=bold)


def spreads(readings: Sequence[ReadingRow]) -> list[str]:
    """How wide each question throws the headline, widest first, one sentence a base."""
    sentences = []
    for base in dict.fromkeys(row.base for row in readings):
        rows = [row for row in readings if row.base == base]
        spreads = []
        for question in dict.fromkeys(row.question for row in rows):
            widths, ranges = [], []
            for key in ("over_level", "over_pitch_only"):
                gains = [getattr(row, key) for row in rows if row.question == question]
                widths.append(max(gains) - min(gains))
                ranges.append(f"{min(gains):.1f} to {max(gains):.1f} % {key.replace('_', ' ')}")
            spreads.append((max(widths), f"{question} {', '.join(ranges)}"))
        ordered = "; ".join(text for _, text in sorted(spreads, reverse=True))
        sentences.append(f"From {base}: {ordered}.")
    return sentences


def ceilings(results: Results) -> str:
    """Each way to choose the attitude with its share of the best."""
    rows = [
        [
            base,
            LAW_LABELS.get(row.law, ""),
            row.name,
            f"{row.gain_percent:+.2f} %",
            f"{100 * row.share:.1f} %",
        ]
        for base, entries in results.ceilings.items()
        for row in entries
    ]
    head = ["scenario", "law", "attitude", "over level", "share of the best"]
    return table("Each law against the best possible in the same scenario", head, rows, text=3)


def claims(results: Results) -> str:
    """The paper's claims in words, with figures."""
    headline = results.headline
    claims, laws = headline.claims, headline.laws
    counts = ", ".join(f"{LAW_LABELS[law]} {claims.fades_below_0_db[law]}" for law in PAPER_LAWS)
    below = ", ".join(f"{100 * laws[law]['outage']['0']:.1f} %" for law in PAPER_LAWS)
    excess, at = 100 * claims.outage_worst_excess, claims.outage_worst_excess_at_db
    dominates = f"its outage exceeds the better benchmark's by up to {excess:.1f} points, at {at:.1f} dB"
    mine = [row for row in results.ceilings[headline.scenario] if row.law == "three_axis"]
    gain = {row.kind: row for row in mine if row.kind in ("held", "flown")}
    tracked = 100 * gain["flown"].gain_percent / gain["held"].gain_percent
    best = f"{tracked:.0f} % of the law's own gain, {100 * gain['flown'].share:.0f} % of what an attitude could win"
    rows = [
        ["fewer deep-fade events", f"fades below 0 dB: {counts}; time below 0 dB: {below}"],
        ["outage dominates uniformly", dominates if excess > 0 else "it does at every threshold"],
        ["partial tracking already realises the bulk of the gain", best],
    ]
    return table("Three claims in words", ["the paper says", "here"], rows, text=2)


def errata(results: Results) -> str:
    """The slips of the paper's text."""
    rows = [
        [
            erratum.where,
            erratum.text,
            erratum.holds,
            "; ".join(f"{label} {value:.3g} {unit}" for label, value, unit in erratum.figures),
        ]
        for erratum in results.errata
    ]
    head = ["where", "the text says", "what holds", "figures (Table I; gains ideally tracked, over level)"]
    return table("Slips of the text, and what following them does", head, rows, text=4)
