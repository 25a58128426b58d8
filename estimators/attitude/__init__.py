"""Attitude estimators: accelerometer and gyro in, tilt and vertical acceleration out.

`quaternion_ekf` [SG14], `tilt_kalman` [Lee16], `accelerometer_norm` and `reference` (what Lee16 compares it
with), and `adapters` to other people's libraries; `alignment` gives them their start.
"""
