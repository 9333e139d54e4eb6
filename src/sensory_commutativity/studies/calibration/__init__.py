"""Do the intervals and tests of the tables keep what they promise? Simulated: make calibration."""
