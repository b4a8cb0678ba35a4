"""Flying for the scripts: plans, one flight or many, and what is written of them."""

import warnings
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from tqdm import tqdm

import a2s_drake
import diagrams
from a2s_drake import Flight, FlightEnded, Scenario, ScenarioError, compute_metrics, run_flight
from a2s_drake.common.files import in_words, what_is_kept, written_whole
from a2s_drake.flight.folder import PLAN
from a2s_drake.flight.folder import write_results as write_folder
from a2s_drake.flight.log import Sample
from a2s_drake.guidance.laws import find_law
from a2s_drake.guidance.plan.cache import (
    OtherPlanError,
    find_plan,
    kept_plan,
    load_plan,
    make_plan,
    plan_file,
    plan_for_law,
)
from a2s_drake.guidance.plan.plan import Progress
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.study.pool import fly_each, worker_processes
from a2s_drake.study.store import FlightStore, code_digest, load_or_fly
from a2s_drake.views.replay import write_replay
from diagrams import build_closed_loop
from scripts.common import UsageError, show_warnings
from scripts.failure import fail, reason


class CampaignEnded(Exception):
    """A campaign that ended early. Its text is one line; its cause is what ended it."""


def plan_ahead(
    scenario: Scenario, time_limit: float | None = None, beside: Path | None = None
) -> AttitudeSpline | None:
    """The plan of a scenario whose law is planned, made with a progress bar unless it is kept from before.

    Args:
      time_limit: wall-clock seconds after which the best plan so far will do.
      beside: the folder of an earlier flight; the plan in it is taken where it is one for this scenario. Where it is
        damaged, a warning names it.
    Raises:
      UsageError: when there is a time limit and nothing to plan, or the mission cannot be planned.
    """
    if not find_law(scenario.attitude_law.name).needs_plan:
        if time_limit is not None:
            raise UsageError(f"--plan-within: the law {scenario.attitude_law.name} makes no plan")
        return None
    if time_limit is not None and not time_limit >= 0.0:
        raise UsageError(f"--plan-within {time_limit}: must be at least 0")
    if beside is not None:
        try:
            return load_plan(beside / PLAN, scenario)
        except (FileNotFoundError, NotADirectoryError, OtherPlanError):
            pass
        except (OSError, ValueError) as error:
            warnings.warn(f"the plan beside the scenario is damaged and is not flown: {error}", stacklevel=2)
    try:
        with tqdm(desc="planning", unit=" steps", leave=False, disable=None) as bar:

            def show(progress: Progress) -> None:
                bar.set_postfix_str(f"{progress.phase}, {progress.throughput:.3f} bit/Hz")
                bar.update()

            return kept_plan(scenario, show, time_limit=time_limit)
    except ValueError as error:
        raise UsageError(error) from error


def fly(
    scenario: Scenario,
    row: int = 0,
    observer: Callable[[Sample], Any] | None = None,
    plan: AttitudeSpline | None = None,
) -> Flight:
    """Flies a validated scenario in closed loop, with a progress bar in the given row of the terminal.

    With an observer, which is called with each sample, it flies no faster than real time; with a plan, to that plan.
    """
    label = scenario.attitude_law.name
    with tqdm(total=len(scenario.sample_times()), desc=label, position=row, leave=False, disable=None) as bar:
        rate = 0.0 if observer is None else 1.0
        diagram = build_closed_loop(scenario, plan=plan or plan_for_law(scenario))
        return run_flight(diagram, scenario, bar.update, observer=observer, target_realtime_rate=rate)


def plan_quietly(scenario: Scenario, _place: int) -> None:
    """Makes and keeps the plan of a scenario, without a progress bar of its own."""
    with warnings.catch_warnings():
        show_warnings()  # A worker process does not know how its parent shows them.
        make_plan(scenario)


def fly_quietly(scenario: Scenario, _place: int) -> Flight:
    """Flies a validated scenario in closed loop, without a progress bar of its own."""
    with warnings.catch_warnings():
        show_warnings()
        return run_flight(build_closed_loop(scenario, plan=plan_for_law(scenario)), scenario)


def fly_campaign(scenarios: Mapping[str, Scenario], folder: Path, jobs: int) -> dict[str, Flight]:
    """Flights by name; those flown before by the same code are taken from `folder`, and new ones kept there.

    Raises:
      CampaignEnded: on an interrupt, on a flight that ends early or cannot be planned, or when a worker or the disk
        fails.
    """
    digest = code_digest(*(Path(module.__file__).parent for module in (a2s_drake, diagrams)))
    kept = f"flights done are kept in {folder}"
    try:
        with warnings.catch_warnings(), worker_processes(jobs) as workers:
            show_warnings()
            store = FlightStore(folder, digest)
            missing = {name: scenario for name, scenario in scenarios.items() if not store.holds(scenario)}
            _plan_each(missing, workers)
            done = load_or_fly(scenarios, fly_quietly, store, workers)
            return dict(tqdm(done, total=len(scenarios), unit="flight", disable=None))
    except FlightEnded as ended:
        raise CampaignEnded(f"{ended}; {keep_samples(ended, folder / 'ended')}; {kept}") from ended
    # The planner checks more than the validation of a scenario can, and then raises ScenarioError.
    except (KeyboardInterrupt, OSError, BrokenProcessPool, ScenarioError) as error:
        raise CampaignEnded(f"{reason(error)}; {kept}") from error


def _plan_each(scenarios: Mapping[str, Scenario], workers: Executor) -> None:
    """Makes every plan that these flights need and that is not kept whole, each of them once."""
    needed = {
        plan_file(scenario): scenario
        for scenario in scenarios.values()
        if find_law(scenario.attitude_law.name).needs_plan
    }
    missing = {file.name: scenario for file, scenario in needed.items() if find_plan(scenario) is None}
    if missing:
        made = fly_each(missing, plan_quietly, workers)
        for _ in tqdm(made, desc="planning", total=len(missing), unit="plan", leave=False, disable=None):
            pass


def fly_study(
    scenarios: Mapping[str, Scenario], out: Path, jobs: int, tell: Callable[[dict[str, Flight]], str], file: str
) -> int:
    """Flies a study, prints what `tell` makes of its flights, and writes that to a file in `out`; the exit code."""
    try:
        flights = fly_campaign(scenarios, out / "flights", jobs)
    except CampaignEnded as ended:
        return fail(ended)
    report = tell(flights)
    print(report)
    with what_is_kept(f"the flights are in {out / 'flights'}"), written_whole(out / file) as part:
        part.write_text(report + "\n", encoding="utf-8")
    print(f"\n{file} and the flights are in {out}")
    return 0


def keep_samples(ended: FlightEnded, folder: Path) -> str:
    """Writes what there is of a flight that ended early; says in words where it is, or why it is nowhere."""
    try:
        write_results(ended.flight, folder)
    except OSError as failure:
        return f"its samples are lost: {in_words(failure)}"
    return f"its {len(ended.flight.time)} samples are in {folder}"


def write_results(
    flight: Flight, folder: Path, plan: AttitudeSpline | None = None, *, csv: bool = False, replay: bool = False
) -> None:
    """`a2s_drake.flight.folder.write_results`, with replay.html where it is asked for."""
    write_folder(flight, folder, plan, csv=csv, replay=write_replay if replay else None)


def summary(flight: Flight) -> str:
    """A flight in one line."""
    metrics = compute_metrics(flight)
    solver = f"{metrics['solver']['failures']} solver failures" if metrics["solver"]["present"] else "no solver"
    return (
        f"{metrics['law']}: {metrics['throughput_bit_per_hz']:.3f} bit/Hz over {flight.time[-1]:.2f} s, "
        f"position error at most {100 * metrics['position_error_max_m']:.2f} cm, {solver}, "
        f"{metrics['real_time_factor']:.2g} times real time"
    )
