"""The paper against what is flown here."""
