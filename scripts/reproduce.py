"""Reproduces the paper: flies it, varies every reading, and writes report.html, results.json and the figures."""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long

import diagrams
from a2s_drake.study.paper.attribution import without_rate_bound
from a2s_drake.study.paper.reproduction import HEADLINE, PRINTED, headline_flights, report_scenarios
from a2s_drake.views.replay import write_replay
from a2s_drake.views.report.write import write_report
from scripts import common, flying
from scripts.failure import fail, reason


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be worked with; 1 for a flight that ended early; 130 when interrupted."""
    parser = common.Parser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="the headline scenario alone")
    common.add_out_argument(parser, "results/reproduce, or results/reproduce-quick")
    common.add_jobs_argument(parser)
    common.add_replay_argument(parser, "the headline flight under three axes")
    try:
        arguments = parser.parse_args(argv)
        common.check_jobs(arguments.jobs)
        default = "results/reproduce-quick" if arguments.quick else "results/reproduce"
        out = common.make_study_folder(arguments.out, default, "figures")
    except common.UsageError as error:
        return fail(error)
    bases = {name: diagrams.load_scenario(name) for name in (HEADLINE, PRINTED)}
    scenarios = report_scenarios(bases, quick=arguments.quick)
    try:
        flights = flying.fly_campaign(scenarios, out / "flights", arguments.jobs)
    except flying.CampaignEnded as ended:
        return fail(ended)
    # Both bases are named scenarios: there is nothing in them that planning could refuse.
    unbounded = None if arguments.quick else flying.plan_ahead(without_rate_bound(bases[PRINTED]))
    with common.what_is_kept(f"flights done are kept in {out / 'flights'}"):
        results = write_report(bases, flights, out, unbounded)
    gains = results.headline.gain_percent
    print(f"three axes over level {gains.over_level:+.2f} %, over pitch only {gains.over_pitch_only:+.2f} %")
    if results.planned is not None:
        gains = results.planned.gain_percent
        print(f"Table I as printed: three axes over level {gains.three_axis_over_level:+.2f} %, ", end="")
        print(f"planned {gains.planned_over_level:+.2f} %")
    (out / "replay.html").unlink(missing_ok=True)
    if arguments.replay:
        try:
            write_replay(headline_flights(flights)["three_axis"], out / "replay.html")
        except OSError as failure:
            return fail(failure, f"{reason(failure)}; the report is in {out}")
    print(f"report.html, results.json{', replay.html' if arguments.replay else ''} and figures are in {out}")
    return 0


if __name__ == "__main__":
    common.run(main)
