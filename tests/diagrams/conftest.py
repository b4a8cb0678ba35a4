import pytest

from a2s_drake import Scenario


@pytest.fixture
def short(scenario: Scenario) -> Scenario:
    """Table I for six samples."""
    return scenario.with_value("simulation.duration", 0.1)
