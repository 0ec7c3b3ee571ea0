"""The film and its amplifier: network, gain by frequency, calibration, response in time, noise; in SI."""
