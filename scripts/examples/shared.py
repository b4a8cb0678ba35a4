"""What the examples share, so that each can keep to its point: command line, errors, saving the picture."""

from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from a2s_drake import FlightEnded, ScenarioError
from a2s_drake.views.figures import save_figure
from scripts import common
from scripts.common import run
from scripts.failure import fail

__all__ = ["run", "run_example"]

FOLDER = "results/examples"

# What an option is by default, a number or a list of texts, and its help.
Option = tuple[float | list[str], str]


def run_example(
    name: str, show: Callable[..., Figure], description: str | None, argv: list[str] | None, **options: Option
) -> int:
    """Calls `show` with its options and writes the figure that it returns to `--out`, under the example's name.

    Args:
      options: by name, as `show` calls them and `--name` on the command line; `show` gets a number or a list of texts.
    Returns:
      0; 2 for input that cannot be worked with; 1 for a flight that ended early, 130 for an interrupted one.
    """
    parser = common.Parser(name, description=description)
    common.add_out_argument(parser, FOLDER)
    for option, (default, help_text) in options.items():
        kind = {"nargs": "+"} if isinstance(default, list) else {"type": type(default)}
        parser.add_argument(f"--{option}", default=default, help=f"{help_text} (default: %(default)s)", **kind)
    try:
        given = vars(parser.parse_args(argv))
        folder = given.pop("out") or Path(FOLDER)
        common.make_folder(folder)
        figure = show(**given)
    except (common.UsageError, ScenarioError, FlightEnded) as error:
        return fail(error)
    save_figure(figure, folder / name)
    print(f"picture: {folder / name}.png and .svg")
    return 0
