"""Tables of the calibration; one per module."""
