"""Flies a scenario, times the MPC on its problems, and checks its accuracy, beside other solvers and over horizons."""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
import json
from pathlib import Path

from tqdm import tqdm

from a2s_drake import FlightEnded, ScenarioError
from a2s_drake.benchmark.growth import growth_figure
from a2s_drake.benchmark.report import benchmark_text
from a2s_drake.benchmark.suite import Benchmark
from a2s_drake.common.files import written_whole
from a2s_drake.common.packages import is_installed
from a2s_drake.views.figures import save_figure
from scripts import common, flying
from scripts.failure import fail, reason


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ended early; 130 when interrupted."""
    parser = common.Parser(description=__doc__)
    common.add_scenario_arguments(parser, default="paper_calibrated", out="results/benchmark")
    parser.add_argument("--json", type=common.place, metavar="FILE", help="write the numbers there as well")
    parser.add_argument("--no-peers", action="store_true", help="leave out CasADi's solvers, even where it is there")
    parser.add_argument("--peers-every", type=int, default=20, metavar="K", help="they solve every K-th problem (20)")
    try:
        arguments = parser.parse_args(argv)
        folder = arguments.out or Path("results/benchmark")
        common.check_count(arguments.peers_every, "--peers-every")
        casadi_every = 0 if arguments.no_peers or not is_installed("casadi") else arguments.peers_every
        benchmark = Benchmark(common.resolve_scenario(arguments, []), casadi_every)
        benchmark.check()
        if arguments.json is not None:
            common.check_file(arguments.json, "--json")
        common.make_folder(folder)
    except (common.UsageError, ScenarioError) as error:
        return fail(error)
    try:
        summary = benchmark.run(lambda name, n: tqdm(total=n, desc=name, leave=False, disable=None).update)
    except (FlightEnded, KeyboardInterrupt) as ended:
        samples = f"; {flying.keep_samples(ended, folder / 'ended')}" if isinstance(ended, FlightEnded) else ""
        return fail(ended, f"{reason(ended)}{samples}")
    print(benchmark_text(summary))
    if not casadi_every and not arguments.no_peers:
        print("\nCasADi's solvers need the package casadi: pip install 'a2s_drake[bench]'")
    save_figure(growth_figure(summary.growth), folder / "growth")
    if arguments.json is not None:
        with written_whole(arguments.json) as part:
            part.write_text(json.dumps(summary.as_json(), indent=2) + "\n", encoding="utf-8")
    print(f"\nthe picture (growth; PNG and SVG) is in {folder}")
    return 0


if __name__ == "__main__":
    common.run(main)
