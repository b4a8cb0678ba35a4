"""Tries the scripts on random scenarios and bad inputs: each must end in finite numbers or in one line of error."""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tqdm import tqdm

from scripts import common
from scripts.trial.draw import case_of, labels
from scripts.trial.isolation import WORK, endings
from scripts.trial.summary import summary_table
from scripts.trial.verdict import FAULT, judge


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 1 when a case ended otherwise; 2 for options that cannot be worked with."""
    parser = common.Parser(description=__doc__)
    parser.add_argument("--scenarios", type=int, default=500, metavar="N", help="random scenarios (%(default)s)")
    parser.add_argument("--bad", type=int, default=500, metavar="N", help="bad inputs (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="what both are drawn from (%(default)s)")
    parser.add_argument("--only", metavar="K", help="one case alone, by its letter and number, such as s17 or b17")
    common.add_jobs_argument(parser)
    try:
        arguments = parser.parse_args(argv)
        common.check_jobs(arguments.jobs)
        for option, count in (("--scenarios", arguments.scenarios), ("--bad", arguments.bad)):
            if count < 0:
                raise common.UsageError(f"{option} {count}: must be at least 0")
        chosen = [arguments.only] if arguments.only is not None else labels(arguments.scenarios, arguments.bad)
        case_of(chosen[0] if chosen else "s0", arguments.seed)
    except (common.UsageError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    folder = Path(tempfile.mkdtemp(prefix="try_inputs_"))
    counts: Counter[tuple[str, str]] = Counter()
    ended = endings((case_of(label, arguments.seed) for label in chosen), folder, arguments.jobs)
    for case, ending in tqdm(ended, total=len(chosen), unit="case", disable=None):
        kind, wrong = judge(case, ending, folder / case.label)
        counts[case.kind, kind] += 1
        if kind == FAULT or arguments.only:
            said = ending.stderr if len(ending.stderr) <= 2000 else f"{ending.stderr[:1000]}...{ending.stderr[-1000:]}"
            tqdm.write(f"{case.label} ({case.kind}): {kind}: {wrong}\n{case.typed(folder / case.label / WORK)}\n{said}")
        if kind != FAULT:
            shutil.rmtree(folder / case.label)
    print(summary_table(counts))
    faults = sum(count for (_, kind), count in counts.items() if kind == FAULT)
    if faults:
        print(f"\n{faults} faults; their files and what they printed are in {folder}")
        return 1
    shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    common.run(main)
