"""The radio link between UAV and ship."""
