"""What a script says of an error, and the exit code that goes with it."""

import pytest

from a2s_drake import FlightEnded, FlightInterrupted, ScenarioError
from a2s_drake.common.files import ResultsError
from scripts.common import UsageError
from scripts.failure import exit_code, fail
from scripts.flying import CampaignEnded
from tests.support.flights import made_up_flight

FLIGHT = made_up_flight()
CODES = {
    130: [KeyboardInterrupt(), FlightInterrupted("interrupted at t = 1 s", FLIGHT)],
    2: [UsageError("--jobs 0: must be at least 1"), ScenarioError("mpc.horizon = 0: must be at least 1")],
    1: [FlightEnded("the flight ended", FLIGHT), ResultsError("no space left"), OSError("no space left")],
}
CASES = [(error, code) for code, errors in CODES.items() for error in errors]


@pytest.mark.parametrize(("error", "code"), CASES)
def test_each_kind_of_error_has_its_code(error: BaseException, code: int, capsys) -> None:
    assert exit_code(error) == code
    assert fail(error) == code
    assert capsys.readouterr().err == f"error: {str(error) or 'interrupted'}\n"


@pytest.mark.parametrize(("error", "code"), CASES)
def test_a_campaign_ends_with_the_code_of_what_ended_it(error: BaseException, code: int) -> None:
    ended = CampaignEnded("flights done are kept")
    ended.__cause__ = error
    assert exit_code(ended) == code


def test_input_is_refused_whatever_showed_that_it_is_bad() -> None:
    refused = UsageError("--out results: cannot be made")
    refused.__cause__ = OSError("permission denied")
    assert exit_code(refused) == 2


def test_a_file_is_named(capsys) -> None:
    assert fail(OSError(28, "No space left on device", "flight.npz")) == 1
    assert capsys.readouterr().err == "error: flight.npz: No space left on device\n"
