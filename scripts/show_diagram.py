"""Shows a diagram: its blocks, ports with sizes and units, and wires, as text or as a picture."""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long

from a2s_drake.common.files import written_whole
from a2s_drake.views.graph import FORMATS, GraphvizError, read_graph
from diagrams import BUILDERS
from scripts import common
from scripts.failure import fail


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be worked with; 1 when Graphviz is missing or fails."""
    parser = common.Parser(description=__doc__)
    parser.add_argument("name", nargs="?", metavar="NAME", help=f"the diagram: {', '.join(BUILDERS)}")
    parser.add_argument("--format", choices=FORMATS, default="text", help="default: %(default)s")
    parser.add_argument("--depth", type=int, metavar="N", help="levels of diagrams to open (default: all; 0: none)")
    parser.add_argument("--list", action="store_true", help="name the diagrams, with what each is")
    parser.add_argument("--scenario", default="paper", help="as for simulate.py (default: %(default)s)")
    common.add_set_argument(parser)
    parser.set_defaults(duration=None)
    parser.add_argument("--out", type=common.place, metavar="FILE", help="where to write (default: to the terminal)")
    try:
        arguments = parser.parse_args(argv)
        if arguments.list:
            print("\n".join(f"{name:<16}{_first_line(build)}" for name, build in BUILDERS.items()))
            return 0
        if arguments.name not in BUILDERS:
            found = "no NAME" if arguments.name is None else f"no diagram named {arguments.name!r}"
            raise common.UsageError(f"{found}; there are {', '.join(BUILDERS)}")
        if arguments.depth is not None and arguments.depth < 0:
            raise common.UsageError(f"--depth {arguments.depth}: must be at least 0")
        scenario = common.resolve_scenario(arguments, [])
        if arguments.out is not None:
            common.check_file(arguments.out, "--out")
    except common.UsageError as error:
        return fail(error)
    try:
        drawn = FORMATS[arguments.format](read_graph(BUILDERS[arguments.name](scenario), arguments.depth))
    except GraphvizError as failure:
        return fail(failure)
    if arguments.out is None:
        print(drawn, end="")
        return 0
    with written_whole(arguments.out) as part:
        part.write_text(drawn, encoding="utf-8")
    print(f"written to {arguments.out}")
    return 0


def _first_line(build: object) -> str:
    return (build.__doc__ or "").partition("\n")[0]


if __name__ == "__main__":
    common.run(main)
