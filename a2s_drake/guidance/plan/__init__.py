"""An attitude planned before take-off."""
