"""Flies a scenario under each disturbance that the controller is not told of, and prints the table."""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
from functools import partial
from pathlib import Path

from a2s_drake import ScenarioError
from a2s_drake.study.robustness import robustness_scenarios, robustness_table
from scripts import common, flying
from scripts.failure import fail


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ended early; 130 when interrupted."""
    parser = common.Parser(description=__doc__)
    common.add_scenario_arguments(parser, default="paper_calibrated", out="results/robustness")
    common.add_jobs_argument(parser)
    try:
        arguments = parser.parse_args(argv)
        common.refuse_law(arguments)
        common.refuse_disturbance(arguments)
        common.check_jobs(arguments.jobs)
        base = common.resolve_scenario(arguments, [])
        scenarios = robustness_scenarios(base)
        common.check_folder(arguments.out or Path("results/robustness"))
        flying.plan_ahead(base)  # What cannot be planned is refused before anything is written.
        out = common.make_study_folder(arguments.out, "results/robustness")
    except (common.UsageError, ScenarioError) as error:
        return fail(error)
    tell = partial(robustness_table, law=base.attitude_law.name)
    return flying.fly_study(scenarios, out, arguments.jobs, tell, "robustness.md")


if __name__ == "__main__":
    common.run(main)
