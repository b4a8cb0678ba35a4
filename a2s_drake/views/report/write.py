"""Writes everything that the report consists of into a folder."""

import json
from collections.abc import Mapping
from pathlib import Path

from a2s_drake.common.files import written_whole
from a2s_drake.flight.log import Flight
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.study.paper.reproduction import HEADLINE, PRINTED, collect_results, headline_flights, printed_flights
from a2s_drake.study.paper.results import Results
from a2s_drake.views.figures import save_figure
from a2s_drake.views.report import report_html
from a2s_drake.views.report.pictures import paper_pictures, planned_pictures, study_pictures


def write_report(
    bases: Mapping[str, Scenario],
    flights: Mapping[str, Flight],
    folder: Path,
    unbounded: AttitudeSpline | None = None,
) -> Results:
    """Writes report.html, results.json and figures/*.png and *.svg into a folder; returns the results.

    Args:
      bases: the scenarios named HEADLINE and PRINTED.
      flights: those of `reproduction.report_scenarios`, by name.
      unbounded: as for `reproduction.collect_results`; without it the report is a quick one.
    """
    results = collect_results(bases, flights, unbounded)
    paper = paper_pictures(headline_flights(flights))
    planned = planned_pictures(results.planned, printed_flights(flights)) if results.planned is not None else {}
    pictures = paper | planned | study_pictures(results, bases[PRINTED])
    figures = folder / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    for name, (figure, _) in pictures.items():
        save_figure(figure, figures / name)
    captions = {name: caption for name, (_, caption) in pictures.items()}
    page = report_html(results, captions, figures, bases[HEADLINE], list(paper), list(planned))
    for name, text in (("results.json", json.dumps(results.as_json(), indent=2) + "\n"), ("report.html", page)):
        with written_whole(folder / name) as part:
            part.write_text(text, encoding="utf-8")
    return results
