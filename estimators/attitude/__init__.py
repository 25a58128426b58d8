"""Attitude estimators: accelerometer and gyro in, tilt and vertical acceleration out."""
