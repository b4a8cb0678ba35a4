"""The report: one HTML page that holds everything it shows and loads nothing."""

import base64
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from a2s_drake.figures import LAW_LABELS
from a2s_drake.metrics import OUTAGE_THRESHOLDS_DB
from a2s_drake.parameters import LAWS
from a2s_drake.reproduction import PRINTED
from a2s_drake.scenario import Scenario
from a2s_drake.table_one import table_one

_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>a2s_drake: the paper reproduced</title>
<style>
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; margin: 0 auto; }
body { max-width: 74rem; padding: 1rem 1.2rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; } h2 { font-size: 1.25rem; margin-top: 2.6rem; }
p, li { max-width: 46rem; }
.headline { display: flex; flex-wrap: wrap; gap: .8rem; margin: 1.2rem 0; padding: 0; list-style: none; }
.headline li { border-left: 4px solid #0072B2; background: #f3f7fa; padding: .5rem 1rem; min-width: 13rem; }
.headline b { display: block; font-size: 1.5rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; margin: .8rem 0; }
caption { text-align: left; font-weight: 600; padding-bottom: .3rem; }
th, td { padding: .25rem .7rem; border-bottom: 1px solid #ddd; text-align: right; vertical-align: top; }
.text { text-align: left; } td:not(.text), td:first-child { white-space: nowrap; }
.tables { display: flex; flex-wrap: wrap; gap: 0 3rem; align-items: start; } .tables > div { max-width: 100%; }
thead th { border-bottom: 2px solid #555; } tr.base td { font-weight: 600; background: #f3f7fa; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(21rem, 100%), 1fr)); gap: 1.4rem; }
figure { margin: 0; } figure img { width: 100%; height: auto; }
figcaption { font-size: .85rem; color: #444; }
footer { margin-top: 3rem; font-size: .85rem; color: #555; }
</style>
</head>
<body>
$body
</body>
</html>
""")


def _table(
    caption: str, head: Sequence[str], rows: Sequence[Sequence[str]], *, text: int = 1, bold: Sequence[int] = ()
) -> str:
    """An HTML table; the first `text` columns are words, the rows numbered in `bold` stand out."""

    def line(cells: Sequence[str], tag: str) -> str:
        return "".join(
            f'<{tag} class="text">{escape(cell)}</{tag}>' if column < text else f"<{tag}>{escape(cell)}</{tag}>"
            for column, cell in enumerate(cells)
        )

    body = "\n".join(
        f"<tr{' class=base' if index in bold else ''}>{line(row, 'td')}</tr>" for index, row in enumerate(rows)
    )
    return (
        f'<div class="scroll"><table><caption>{escape(caption)}</caption>\n'
        f"<thead><tr>{line(head, 'th')}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>"
    )


def _figures(captions: Mapping[str, str], folder: Path, names: Sequence[str]) -> str:
    blocks = []
    for name in names:
        data = base64.b64encode((folder / f"{name}.svg").read_bytes()).decode()
        number = list(captions).index(name) + 1
        blocks.append(
            f'<figure id="{name}"><img alt="{escape(captions[name])}" src="data:image/svg+xml;base64,{data}">'
            f"<figcaption>Fig. {number}. {escape(captions[name])}</figcaption></figure>"
        )
    return '<div class="figures">\n' + "\n".join(blocks) + "\n</div>"


def _against(results: Mapping[str, Any]) -> str:
    gains, paper = results["headline"]["gain_percent"], results["paper_gain_percent"]
    laws = results["headline"]["laws"]
    rows = [
        ["three axes over level", f"+{paper['over_level']} %", f"{gains['over_level']:+.2f} %"],
        ["three axes over pitch only", f"+{paper['over_pitch_only']} %", f"{gains['over_pitch_only']:+.2f} %"],
    ]
    head = ["law", "throughput (bit/Hz)", *(f"outage {t:g} dB" for t in OUTAGE_THRESHOLDS_DB)]
    head += ["position error max (cm)", "rms (cm)", "attitude error rms, roll pitch yaw (deg)", "solver failures"]
    fares = []
    for law in LAWS:
        entry = laws[law]
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
    uses = [
        [name.replace("_", " "), *(f"{100 * laws[law]['bounds'][name]['largest_use']:.0f} %" for law in LAWS)]
        for name in laws["level"]["bounds"]
    ]
    return "\n".join(
        [
            '<div class="tables">',
            _table("Throughput, paper against here", ["gain of", "paper", "here"], rows),
            _table(
                "Largest use of each bound (0 % mid-range, 100 % bound)",
                ["", *(LAW_LABELS[law] for law in LAWS)],
                uses,
            ),
            "</div>",
            _table("The three laws in closed loop (the paper shows these as curves, without figures)", head, fares),
        ]
    )


def _hangs_on(results: Mapping[str, Any]) -> str:
    rows, bold = [], []
    home = {row["base"]: row for row in results["readings"] if row["is_base"]}
    for index, row in enumerate(results["readings"]):
        moved = row["over_level"] - home[row["base"]]["over_level"]
        if row["is_base"]:
            bold.append(index)
        rows.append(
            [
                row["base"],
                row["question"],
                row["answer"] + (" (base)" if row["is_base"] else ""),
                f"{row['over_level']:+.2f}",
                f"{moved:+.2f}",
                f"{row['over_pitch_only']:+.2f}",
                f"{100 * row['position_error_max_m']:.1f}",
                str(row["solver_failures"]),
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
    return _table("Each reading in closed loop: gain of three axes", head, rows, text=3, bold=bold)


def _spreads(results: Mapping[str, Any]) -> list[str]:
    """How wide each question throws the headline, widest first, one sentence a base."""
    sentences = []
    for base in dict.fromkeys(row["base"] for row in results["readings"]):
        rows = [row for row in results["readings"] if row["base"] == base]
        spreads = []
        for question in dict.fromkeys(row["question"] for row in rows):
            widths, ranges = [], []
            for key in ("over_level", "over_pitch_only"):
                gains = [row[key] for row in rows if row["question"] == question]
                widths.append(max(gains) - min(gains))
                ranges.append(f"{min(gains):.1f} to {max(gains):.1f} % {key.replace('_', ' ')}")
            spreads.append((max(widths), f"{question} {', '.join(ranges)}"))
        ordered = "; ".join(text for _, text in sorted(spreads, reverse=True))
        sentences.append(f"From {base}: {ordered}.")
    return sentences


def _ceilings(results: Mapping[str, Any]) -> str:
    rows = [
        [
            base,
            LAW_LABELS.get(row["law"], ""),
            row["name"],
            f"{row['gain_percent']:+.2f} %",
            f"{100 * row['share']:.1f} %",
        ]
        for base, entries in results["ceilings"].items()
        for row in entries
    ]
    head = ["scenario", "law", "attitude", "over level", "share of the best"]
    return _table("Each law against the best possible in the same scenario", head, rows, text=3)


def _claims(results: Mapping[str, Any]) -> str:
    headline = results["headline"]
    claims, laws = headline["claims"], headline["laws"]
    counts = ", ".join(f"{LAW_LABELS[law]} {claims['fades_below_0_db'][law]}" for law in LAWS)
    below = ", ".join(f"{100 * laws[law]['outage']['0']:.1f} %" for law in LAWS)
    excess, at = 100 * claims["outage_worst_excess"], claims["outage_worst_excess_at_db"]
    dominates = f"its outage exceeds the better benchmark's by up to {excess:.1f} points, at {at:.1f} dB"
    mine = [row for row in results["ceilings"][headline["scenario"]] if row["law"] == "three_axis"]
    gain = {row["kind"]: row for row in mine if row["kind"] in ("ideal", "flown")}
    tracked = 100 * gain["flown"]["gain_percent"] / gain["ideal"]["gain_percent"]
    best = f"{tracked:.0f} % of the law's own gain, {100 * gain['flown']['share']:.0f} % of what an attitude could win"
    rows = [
        ["fewer deep-fade events", f"fades below 0 dB: {counts}; time below 0 dB: {below}"],
        ["outage dominates uniformly", dominates if excess > 0 else "it does at every threshold"],
        ["partial tracking already realises the bulk of the gain", best],
    ]
    return _table("Three claims in words", ["the paper says", "here"], rows, text=2)


def _errata(results: Mapping[str, Any]) -> str:
    rows = [
        [
            erratum["where"],
            erratum["text"],
            erratum["holds"],
            "; ".join(f"{label} {value:.3g} {unit}" for label, value, unit in erratum["figures"]),
        ]
        for erratum in results["errata"]
    ]
    head = ["where", "the text says", "what holds", "figures (Table I; gains ideally tracked, over level)"]
    return _table("Slips of the text, and what following them does", head, rows, text=4)


def report_html(
    results: Mapping[str, Any], captions: Mapping[str, str], folder: Path, base: Scenario, paper_figures: Sequence[str]
) -> str:
    """The page.

    Args:
      results: of `reproduction.collect_results`.
      captions: of all figures by name, in order; their SVGs lie in `folder`.
      base: the headline scenario.
      paper_figures: which figures belong to the paper; the others go with the sections they illustrate.
    """
    gains, paper = results["headline"]["gain_percent"], results["paper_gain_percent"]
    ideal, printed = results["ideal"][results["headline"]["scenario"]], results["ideal"][PRINTED]
    quick = "readings" not in results
    parts = [
        "<h1>Does attitude control win back a two-ray link? The paper reproduced</h1>",
        "<p>M. Bajja, A. K. A. H. Saliah, H. El Hammouti, D. Bonilla Licea and G. Silano, <i>3D Euler-Angle "
        "Orientation Control for Two-Ray Fading Mitigation in Maritime Air-to-Sea Communications</i>, IEEE GLOBECOM "
        "2026, flown in closed loop through Drake block diagrams.</p>",
        '<ul class="headline">',
        f"<li><b>{gains['over_level']:+.2f} %</b>over level; the paper prints +{paper['over_level']} %</li>",
        f"<li><b>{gains['over_pitch_only']:+.2f} %</b>over pitch only; the paper prints "
        f"+{paper['over_pitch_only']} %</li>",
        f"<li><b>{ideal['ceiling_percent']['box']:+.1f} %</b>over level is the most any attitude in the "
        f"{base.mpc.attitude_limit_deg:g} deg box wins</li>",
        "</ul>",
        "<p>The headline holds under these readings of what the text leaves open "
        f"(<code>{results['headline']['scenario']}</code>): candidates up to "
        f"{base.attitude_law.candidate_limit_deg:g} deg, where there is none the fallback "
        f"<code>{base.attitude_law.fallback}</code>, a wavelength of "
        f"{100 * base.link.wavelength:g} cm, and the vehicle constants of a public airframe of the same family.</p>",
    ]
    if quick:
        parts.append("<p><b>Quick report</b>: the headline scenario alone; the readings were not flown.</p>")
    parts += [
        "<h2>Paper against here</h2>",
        _against(results),
        _claims(results),
        _table("Table I as used", ["", "paper", "here"], table_one(base)),
        "<h2>The figures, redrawn</h2>",
        _figures(captions, folder, paper_figures),
    ]
    if not quick:
        parts += [
            "<h2>What it hangs on</h2>",
            "<p>Each reading, one change at a time, from the headline's readings and from Table I "
            "as printed. Every line is three flights in closed loop.</p>",
            *(f"<p>{escape(sentence)}</p>" for sentence in _spreads(results)),
            _figures(captions, folder, ["readings"]),
            _hangs_on(results),
        ]
    parts += [
        "<h2>Against the best possible</h2>",
        f"<p>The ceilings maximise the exact |g|<sup>2</sup> over the attitude box, not the affine phase. In Table I "
        f"no candidate is feasible in {100 * printed['empty_share']['three_axis']:.1f} % of the samples for three axes "
        f"and {100 * printed['empty_share']['pitch_only']:.1f} % for pitch only, and the vehicle could rest at only "
        f"{100 * printed['hoverable_share']['nearest']:.0f} % of the three-axis references. The affine phase errs by "
        f"up to {printed['affine_phase_error_rad']['max']:.2f} rad in the box.</p>",
        _figures(captions, folder, ["ceiling", "affine_phase_error"]),
        _ceilings(results),
        "<h2>Errata</h2>",
        _errata(results),
        "<footer>" + escape(", ".join(f"{name} {value}" for name, value in results["versions"].items())) + "</footer>",
    ]
    return _PAGE.substitute(body="\n".join(parts))
