"""The report's page: its sections in order, with the words between them."""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from a2s_drake.scenario.scenario import Scenario
from a2s_drake.study.paper.reproduction import PRINTED
from a2s_drake.study.paper.results import Results
from a2s_drake.study.paper.table_1 import table_1_rows
from a2s_drake.views.report import sections
from a2s_drake.views.report.html import PAGE, figures, table


def _planned_headline(results: Results) -> list[str]:
    if results.planned is None:
        return []
    gain = results.planned.gain_percent.planned_over_level
    return [f"<li><b>{gain:+.2f} %</b>over level is flown by a planned attitude, on Table I as printed</li>"]


def report_html(
    results: Results,
    captions: Mapping[str, str],
    folder: Path,
    base: Scenario,
    paper_figures: Sequence[str],
    planned_figures: Sequence[str],
) -> str:
    """The page.

    Args:
      results: of `reproduction.collect_results`.
      captions: of all figures by name, in order; their SVGs lie in `folder`.
      base: the headline scenario.
      paper_figures: which figures belong to the paper.
      planned_figures: which belong to the law `planned`; the others go with the sections they illustrate.
    """
    gains, paper = results.headline.gain_percent, results.paper_gain_percent
    tracking = results.ideal_tracking
    calibrated, printed = tracking[results.headline.scenario], tracking[PRINTED]
    parts = [
        "<h1>Does attitude control win back a two-ray link? The paper reproduced</h1>",
        "<p>M. Bajja, A. K. A. H. Saliah, H. El Hammouti, D. Bonilla Licea and G. Silano, <i>3D Euler-Angle "
        "Orientation Control for Two-Ray Fading Mitigation in Maritime Air-to-Sea Communications</i>, IEEE GLOBECOM "
        "2026, flown in closed loop through Drake block diagrams.</p>",
        '<ul class="headline">',
        f"<li><b>{gains.over_level:+.2f} %</b>over level; the paper prints +{paper.over_level} %</li>",
        f"<li><b>{gains.over_pitch_only:+.2f} %</b>over pitch only; the paper prints +{paper.over_pitch_only} %</li>",
        f"<li><b>{calibrated.ceiling_percent.box:+.1f} %</b>over level is the most any attitude in the "
        f"{base.mpc.attitude_limit_deg:g} deg box wins</li>",
        *_planned_headline(results),
        "</ul>",
        "<p>The headline holds under these readings of what the text leaves open "
        f"(<code>{results.headline.scenario}</code>): candidates up to "
        f"{base.attitude_law.candidate_limit_deg:g} deg, where there is none the fallback "
        f"<code>{base.attitude_law.fallback}</code>, a wavelength of "
        f"{100 * base.link.wavelength:g} cm, and the vehicle constants of a public airframe of the same family.</p>",
    ]
    if results.readings is None:
        parts.append("<p><b>Quick report</b>: the headline scenario alone; the readings were not flown.</p>")
    parts += [
        "<h2>Paper against here</h2>",
        sections.against(results),
        sections.claims(results),
        table("Table I as used", ["", "paper", "here"], table_1_rows(base)),
        "<h2>The figures, redrawn</h2>",
        figures(captions, folder, paper_figures),
    ]
    if results.planned is not None and results.readings is not None:
        parts += [
            *sections.planned_law(results.planned, figures(captions, folder, planned_figures)),
            "<h2>What it depends on</h2>",
            "<p>Each reading, one change at a time, from the headline's readings and from Table I "
            "as printed. Every line is three flights in closed loop.</p>",
            *(f"<p>{escape(sentence)}</p>" for sentence in sections.spreads(results.readings)),
            figures(captions, folder, ["readings"]),
            sections.reading_table(results.readings),
        ]
    parts += [
        "<h2>Against the best possible</h2>",
        f"<p>The ceilings maximise the exact |g|<sup>2</sup> over the attitude box, not the affine phase. In Table I "
        f"no candidate is feasible in {100 * printed.empty_share['three_axis']:.1f} % of the samples for three axes "
        f"and {100 * printed.empty_share['pitch_only']:.1f} % for pitch only, and the vehicle could rest at only "
        f"{100 * printed.hoverable_share['nearest']:.0f} % of the three-axis references. The affine phase errs by "
        f"up to {printed.affine_phase_error_rad.max:.2f} rad in the box.</p>",
        figures(captions, folder, ["ceiling", "affine_phase_error"]),
        sections.ceilings(results),
        "<h2>Errata</h2>",
        sections.errata(results),
        "<footer>"
        + escape(", ".join(f"{name} {value}" for name, value in results.versions.items() if value))
        + "</footer>",
    ]
    return PAGE.substitute(body="\n".join(parts))
