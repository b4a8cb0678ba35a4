"""Flies the paper's three laws and a scenario's own, and prints them side by side, with two pictures."""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
from concurrent.futures.process import BrokenProcessPool

from a2s_drake import FlightEnded
from a2s_drake.scenario.parts import PAPER_LAWS
from a2s_drake.study.paper.comparison import comparison_table
from a2s_drake.study.pool import fly_each, worker_processes
from a2s_drake.views.figures import attitude_figure, channel_gain_figure, save_figure
from scripts import common, flying
from scripts.failure import fail, reason


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ended early; 130 when interrupted."""
    parser = common.Parser(description=__doc__)
    common.add_scenario_arguments(parser, default="paper_calibrated")
    common.add_jobs_argument(parser)
    try:
        arguments = parser.parse_args(argv)
        common.refuse_law(arguments)
        common.check_jobs(arguments.jobs)
        own = common.resolve_scenario(arguments, [])
        laws = tuple(dict.fromkeys((*PAPER_LAWS, own.attitude_law.name)))
        scenarios = {law: common.resolve_scenario(arguments, [f"attitude_law.name={law}"]) for law in laws}
        folder = arguments.out or common.default_folder(arguments)
        common.check_folder(folder)
        flying.plan_ahead(own)
        common.make_folder(folder)
    except common.UsageError as error:
        return fail(error)
    done = {}
    try:
        with worker_processes(arguments.jobs) as workers:
            for law, flight in fly_each(scenarios, flying.fly, workers):
                flying.write_results(flight, folder / law)
                done[law] = flight
    except (FlightEnded, BrokenProcessPool, OSError, KeyboardInterrupt) as ended:
        words = reason(ended)
        if isinstance(ended, FlightEnded):
            words += f"; {flying.keep_samples(ended, folder / ended.flight.scenario.attitude_law.name)}"
        return fail(ended, f"{words}; flown to the end and kept in {folder}: {', '.join(done) or 'none'}")
    flights = {law: done[law] for law in laws}
    print(comparison_table(flights))
    with common.what_is_kept(f"the flights are in {folder}"):
        save_figure(channel_gain_figure(flights), folder / "channel_gain")
        save_figure(attitude_figure(flights["three_axis"]), folder / "attitude")
    print(f"\nflights and pictures (channel_gain, attitude; PNG and SVG) are in {folder}")
    return 0


if __name__ == "__main__":
    common.run(main)
