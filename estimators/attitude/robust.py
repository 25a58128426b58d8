"""proto"""
from __future__ import annotations
import math
import numpy as np
from filterpy.kalman import KalmanFilter
from baroarma.estimators.attitude import kernels
from baroarma.estimators.attitude import robust_kernels as rk
from baroarma.estimators.attitude.robust_kernels import RobustSettings
from baroarma.estimators.base import UNSEEN_WALK, Alignment, AttitudeEstimator, AttitudeRun, AttitudeState, Signal

class RobustAttitude(AttitudeEstimator, KalmanFilter):
    def __init__(self, *, gyro_noise_sd=math.radians(0.15), accel_noise_sd=0.04, bias_walk=5e-5, scale_walk=1e-5,
        rate_error=0.003, force_error=0.01, velocity_sd=1.0, velocity_time=4.0, limit=3.0, interval=2.0,
        tilt_sd=math.radians(1.0), bias_sd=math.radians(0.05), scale_sd=0.01):
        KalmanFilter.__init__(self, dim_x=10, dim_z=2)
        self.settings = RobustSettings(gyro_noise_sd, accel_noise_sd, bias_walk, scale_walk, rate_error, force_error,
            velocity_sd, velocity_time, limit, interval, 0.5, UNSEEN_WALK, 40.0, 80.0, 0.1, 10.0)
        self.p0 = np.array([tilt_sd]*2+[0.1]*2+[bias_sd]*3+[scale_sd]*3)
        self.reset()
    def reset(self, alignment=None):
        self.alignment = a = alignment or Alignment()
        self.q = np.zeros(4); rk.fill_level(self.q, np.array(a.up))
        self.estimate = np.zeros(8); self.estimate[2:5] = a.gyro_bias
        self.x = np.zeros(10); self.P = np.diag(self.p0**2)
        self.F = np.eye(10); self.Q = np.zeros(5); self.H=np.zeros((2,10)); self.R = np.zeros(1)
        self.held = np.array([*a.gyro_bias, 0, 0, a.gravity]); self.age = np.zeros(3)
        self._started = False
    def step(self, *, dt, accel, gyro, attitude=None):
        r = self._take(np.array([dt if self._started else 0.0]), accel[None], gyro[None])
        return AttitudeState(r.up[0], float(r.acceleration[0]), float(r.acceleration_sd[0]))
    def run(self, t, accel, gyro, attitude=None):
        return self._take(np.diff(t, prepend=t[:1]), accel, gyro)
    def _take(self, dt, accel, gyro):
        n = len(dt)
        out = AttitudeRun(np.empty((n, 3)), np.empty(n), np.empty(n))
        rk.run_robust(dt, kernels.as_array(accel), kernels.as_array(gyro), self.alignment.gravity, self.settings,
            self.q, self.estimate, self.x, self.P, self.F, self.Q, self.H, self.R, self.held, self.age, *out)
        self._started = self._started or n > 0
        return out
