"""The joint Gaussian of height, velocity and altitude samples, written down without any recursion."""

import numpy as np


def motion_maps(t):
    """Return matrices (n, n-1) from accelerations held over the n-1 intervals to height and velocity."""
    n, dt = len(t), np.diff(t)
    height, velocity = np.zeros((n, n - 1)), np.zeros((n, n - 1))
    for j in range(n - 1):
        velocity[j + 1 :, j] = dt[j]
        height[j + 1 :, j] = dt[j] * (t[j + 1 :] - t[j + 1]) + dt[j] ** 2 / 2
    return height, velocity


def joint(t, noise, *, acceleration_sd, height_sd, velocity_sd, bias_sd, bias_walk, offset_sd):
    """Return covariances of height (n, n), velocity (n, n), both (n, n), and of the samples' noise (n, n)."""
    to_height, to_velocity = motion_maps(t)
    lag = np.abs(t[:, None] - t)
    earlier = np.minimum(t[:, None], t) - t[0]
    bias = bias_sd**2 + bias_walk**2 * earlier[:-1, :-1]
    acceleration = bias + np.diag(np.broadcast_to(acceleration_sd, len(t) - 1) ** 2)
    elapsed = t - t[0]
    hh = height_sd**2 + velocity_sd**2 * np.outer(elapsed, elapsed) + to_height @ acceleration @ to_height.T
    vv = velocity_sd**2 + to_velocity @ acceleration @ to_velocity.T
    vh = velocity_sd**2 * np.tile(elapsed, (len(t), 1)) + to_velocity @ acceleration @ to_height.T
    correlated = noise.correlated_sd**2 * np.exp(-lag / noise.correlation_time)
    samples = correlated + noise.white_sd**2 * np.eye(len(t)) + noise.drift_rate**2 * earlier + offset_sd**2
    return hh, vv, vh, samples


def solve(t, z, u, noise, *, smooth, **sds):
    """Return height, velocity and their sds of every row, given the samples up to it (or all of them).

    u (n-1,) are the accelerations of the intervals.
    """
    hh, vv, vh, samples = joint(t, noise, **sds)
    to_height, to_velocity = motion_maps(t)
    rows = []
    for k in range(len(t)):
        seen = np.isfinite(z) & (smooth | (np.arange(len(t)) <= k))
        S = (hh + samples)[np.ix_(seen, seen)]
        gains = np.linalg.solve(S, np.array([hh[k, seen], vh[k, seen]]).T).T
        mean = np.array([to_height[k] @ u, to_velocity[k] @ u]) + gains @ (z - to_height @ u)[seen]
        variance = np.array([hh[k, k], vv[k, k]]) - np.sum(gains * [hh[k, seen], vh[k, seen]], axis=1)
        rows.append([*mean, *np.sqrt(variance)])
    return np.array(rows).T
