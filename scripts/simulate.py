"""Flies one scenario in closed loop and writes scenario.yaml, flight.npz, metrics.json and, if asked, flight.csv."""

import sys

from a2s_drake import FlightEnded, FlightInterrupted, compute_metrics
from a2s_drake.parameters import LAWS
from scripts import common


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ended early; 130 for an interrupted one."""
    parser = common.Parser(description=__doc__)
    common.add_scenario_arguments(parser, default="paper", out="results/SCENARIO/LAW")
    parser.add_argument("--law", choices=LAWS, help="the attitude law; wins over --set attitude_law.name=...")
    parser.add_argument("--csv", action="store_true", help="write the flight as flight.csv too")
    try:
        arguments = parser.parse_args(argv)
        law = [] if arguments.law is None else [f"attitude_law.name={arguments.law}"]
        scenario = common.resolve_scenario(arguments, law)
        folder = arguments.out or common.default_folder(arguments) / scenario.attitude_law.name
        common.make_folder(folder)
    except common.UsageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    try:
        flight = common.fly(scenario)
    except FlightEnded as ended:
        common.write_results(ended.flight, folder, csv=arguments.csv)
        print(f"error: {ended}; its {len(ended.flight.time)} samples are in {folder}", file=sys.stderr)
        return 130 if isinstance(ended, FlightInterrupted) else 1
    common.write_results(flight, folder, csv=arguments.csv)
    metrics = compute_metrics(flight)
    print(
        f"{metrics['law']}: {metrics['throughput_bit_per_hz']:.3f} bit/Hz over {flight.time[-1]:.2f} s, "
        f"position error at most {100 * metrics['position_error_max_m']:.1f} cm, "
        f"{metrics['solver']['failures']} solver failures, {metrics['real_time_factor']:.2g} times real time"
    )
    print(f"written to {folder}")
    return 0


if __name__ == "__main__":
    common.run(main)
