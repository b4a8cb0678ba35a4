"""Flies missions other than Table I under `planned`, the paper's law and level, and prints one table."""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long

import diagrams
from a2s_drake import Flight, ScenarioError
from a2s_drake.study.missions import PAPER, PLANNED, mission_scenarios, missions_report, other_missions, outcome
from scripts import common, flying
from scripts.failure import fail


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ended early; 130 when interrupted."""
    parser = common.Parser(description=__doc__)
    known = list(other_missions())
    help_text = f"which to fly: {', '.join(known)} (default: all)"
    parser.add_argument("mission", nargs="*", metavar="MISSION", help=help_text)
    common.add_set_argument(parser)
    common.add_out_argument(parser, "results/missions")
    common.add_jobs_argument(parser)
    try:
        arguments = parser.parse_args(argv)
        common.refuse_law(arguments)
        common.check_jobs(arguments.jobs)
        missions = arguments.mission or known
        for name in missions:
            if name not in known:
                raise common.UsageError(f"no mission named {name!r}; there are: {', '.join(known)}")
        bases = {base: diagrams.load_scenario(base).with_overrides(arguments.set) for base in (PAPER, PLANNED)}
        scenarios = mission_scenarios(bases, missions)
        out = common.make_study_folder(arguments.out, "results/missions")
    except (common.UsageError, ScenarioError) as error:
        return fail(error)

    def tell(flights: dict[str, Flight]) -> str:
        return missions_report({name: outcome(flights, name) for name in missions})

    return flying.fly_study(scenarios, out, arguments.jobs, tell, "missions.md")


if __name__ == "__main__":
    common.run(main)
