"""Flies the three laws over one scenario and prints them side by side, with two pictures."""

import argparse
import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from tqdm import tqdm

from a2s_drake import FlightEnded, FlightInterrupted
from a2s_drake.comparison import comparison_table
from a2s_drake.figures import attitude_figure, channel_gain_figure
from a2s_drake.parameters import LAWS
from scripts import common


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ended early; 130 when interrupted."""
    parser = argparse.ArgumentParser(description=__doc__)
    common.add_scenario_arguments(parser, default="paper_calibrated")
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: results/<scenario>")
    parser.add_argument("--jobs", type=int, default=2, help="flights at a time (default: %(default)s)")
    arguments = parser.parse_args(argv)
    folder = arguments.out or common.default_folder(arguments)
    try:
        scenarios = [common.resolve_scenario(arguments, [f"attitude_law.name={law}"]) for law in LAWS]
        common.make_folder(folder)
        if arguments.jobs < 1:
            raise common.UsageError(f"--jobs {arguments.jobs}: must be at least 1")
    except common.UsageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    flights = {}
    context = multiprocessing.get_context("spawn")
    lock = (context.RLock(),)
    with ProcessPoolExecutor(arguments.jobs, context, initializer=tqdm.set_lock, initargs=lock) as pool:
        jobs = {
            pool.submit(common.fly, scenario, row): law
            for row, (law, scenario) in enumerate(zip(LAWS, scenarios, strict=True))
        }
        try:
            for job in as_completed(jobs):
                law = jobs[job]
                flights[law] = job.result()
                common.write_results(flights[law], folder / law)
        except (FlightEnded, KeyboardInterrupt) as ended:
            pool.shutdown(cancel_futures=True)
            print(f"error: {ended or 'interrupted'}; what was flown to its end is in {folder}", file=sys.stderr)
            return 1 if isinstance(ended, FlightEnded) and not isinstance(ended, FlightInterrupted) else 130
    flights = {law: flights[law] for law in LAWS}
    channel_gain_figure(list(flights.values())).savefig(folder / "channel_gain.png", dpi=200)
    attitude_figure(flights["three_axis"]).savefig(folder / "attitude.png", dpi=200)
    print(comparison_table(flights))
    print(f"\nflights and pictures (channel_gain.png, attitude.png) are in {folder}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
