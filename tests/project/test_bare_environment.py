"""What a test does not use it does not need: it runs without the other packages of the development environment."""

import subprocess
import sys

import pytest

from tests.support.markdown import ROOT

# As if these packages were not installed: they are not found, and pytest does not load their plugins.
RUN = """
import sys

class Absent:
    def find_spec(name, path=None, target=None):
        if name.partition(".")[0] in {absent!r}:
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, Absent)
import pytest
sys.exit(pytest.main(["-q", "-p", "no:cacheprovider", "-p", "no:hypothesispytest", "-p", "no:xdist", *{tests!r}]))
"""
UNUSED = ["playwright", "casadi", "pygraphviz", "mkdocs", "latex2mathml", "pandas"]


@pytest.mark.parametrize(
    ("absent", "tests"),
    [
        (UNUSED, ["tests/link/test_two_ray.py"]),
        ([*UNUSED, "hypothesis"], ["tests/common/test_wiring.py"]),
    ],
    ids=["but for Hypothesis", "Hypothesis too"],
)
def test_tests_run_without_packages_that_they_do_not_use(absent: list[str], tests: list[str]) -> None:
    code = RUN.format(absent=absent, tests=tests)
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=120.0)
    assert run.returncode == 0, run.stdout + run.stderr
    assert " passed" in run.stdout
