"""Height estimators: vertical acceleration (or the IMU) and barometric height in, height and velocity out."""
