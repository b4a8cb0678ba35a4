"""Reproduces the paper: flies it, varies every reading, and writes report.html, results.json and the figures."""

import json
import sys
import warnings
from pathlib import Path

from tqdm import tqdm

import a2s_drake
import diagrams
from a2s_drake import FlightEnded
from a2s_drake.campaign import worker_processes
from a2s_drake.figures import save_figure
from a2s_drake.gallery import paper_gallery, study_gallery
from a2s_drake.report import report_html
from a2s_drake.reproduction import HEADLINE, PRINTED, collect_results, headline_flights, planned_flights
from a2s_drake.store import FlightStore, code_digest, fly_kept
from scripts import common


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be worked with; 1 for a flight that ended early; 130 when interrupted."""
    parser = common.Parser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="the headline scenario alone")
    parser.add_argument("--jobs", type=int, default=2, help="flights at a time (default: %(default)s)")
    parser.add_argument(
        "--out", type=Path, default=Path("results/reproduce"), metavar="DIR", help="default: %(default)s"
    )
    try:
        arguments = parser.parse_args(argv)
        common.check_jobs(arguments.jobs)
        common.make_folder(arguments.out / "figures")
    except common.UsageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    out, quick = arguments.out, arguments.quick
    warnings.showwarning = lambda message, *_: print(f"warning: {message}", file=sys.stderr)
    bases = {name: diagrams.load_scenario(name) for name in (HEADLINE, PRINTED)}
    planned = planned_flights(bases, quick=quick)
    code = code_digest(*(Path(module.__file__).parent for module in (a2s_drake, diagrams)))
    try:
        store, flights = FlightStore(out / "flights", code), {}
        with worker_processes(arguments.jobs) as workers, tqdm(total=len(planned), unit="flight", disable=None) as bar:
            for name, flight in fly_kept(planned, common.fly_quietly, store, workers):
                flights[name] = flight
                bar.update()
    except (FlightEnded, KeyboardInterrupt) as ended:
        print(f"error: {str(ended) or 'interrupted'}; flights done are kept in {out / 'flights'}", file=sys.stderr)
        return 1 if isinstance(ended, FlightEnded) else 130
    results = collect_results(bases, flights, quick=quick)
    paper = paper_gallery(headline_flights(flights))
    gallery = paper | study_gallery(results, bases[PRINTED])
    for name, (figure, _) in gallery.items():
        save_figure(figure, out / "figures" / name)
    captions = {name: caption for name, (_, caption) in gallery.items()}
    page = report_html(results, captions, out / "figures", bases[HEADLINE], list(paper))
    common.write_text(out / "results.json", json.dumps(results, indent=2) + "\n")
    common.write_text(out / "report.html", page)
    gains = results["headline"]["gain_percent"]
    print(f"three axes over level {gains['over_level']:+.2f} %, over pitch only {gains['over_pitch_only']:+.2f} %")
    print(f"{out / 'report.html'}, {out / 'results.json'} and {len(gallery)} figures in {out / 'figures'}")
    return 0


if __name__ == "__main__":
    common.run(main)
