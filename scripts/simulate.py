"""Flies one scenario in closed loop and writes its scenario.yaml, flight.npz and metrics.json."""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
from collections.abc import Callable
from functools import partial
from pathlib import Path

from a2s_drake import Flight, FlightEnded
from scripts import common, flying
from scripts.failure import fail


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ends early or a failing disk; 130 on Ctrl-C."""
    parser = common.Parser(description=__doc__)
    common.add_scenario_arguments(parser, default="paper", out="results/SCENARIO/LAW")
    common.add_law_arguments(parser)
    parser.add_argument("--csv", action="store_true", help="write the flight as flight.csv too")
    common.add_replay_argument(parser, "the flight")
    parser.add_argument("--meshcat", action="store_true", help="show the flight in a browser while it is flown")
    try:
        arguments = parser.parse_args(argv)
        scenario = common.resolve_scenario(arguments, [f"attitude_law.name={arguments.law}"] if arguments.law else [])
        folder = arguments.out or common.default_folder(arguments) / scenario.attitude_law.name
        common.check_folder(folder)
        plan = flying.plan_ahead(scenario, arguments.plan_within, Path(arguments.scenario).parent)
        common.make_folder(folder)
        view = common.open_live_view(scenario) if arguments.meshcat else None
    except common.UsageError as error:
        return fail(error)
    write = partial(flying.write_results, folder=folder, plan=plan, csv=arguments.csv, replay=arguments.replay)
    code = fly_and_write(partial(flying.fly, scenario, observer=view and view.show, plan=plan), write, folder)
    if view and code != 130:
        common.serve_until_enter()
    return code


def fly_and_write(fly: Callable[[], Flight], write: Callable[[Flight], None], folder: Path) -> int:
    """Flies, writes and prints; returns the exit code."""
    try:
        flight, ended = fly(), None
    except FlightEnded as early:
        flight, ended = early.flight, early
    try:
        write(flight)
    except OSError as failure:
        return fail(failure, f"{ended}; {failure}" if ended else str(failure))
    if ended:
        return fail(ended, f"{ended}; its {len(flight.time)} samples are in {folder}")
    print(flying.summary(flight))
    print(f"written to {folder}" + f"; to watch it, open {folder / 'replay.html'}" * (folder / "replay.html").exists())
    return 0


if __name__ == "__main__":
    common.run(main)
