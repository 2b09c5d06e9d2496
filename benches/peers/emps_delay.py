"""What delay least squares find in the EMPS data: M a + Fv v + Fc sgn(v) + offset + asymmetry |v| + d sgn(v) exp(-|v|/w) = force(t - delay).

    python benches/peers/emps_delay.py emps_estimation.csv emps_validation_pulses.csv

Logged values of the force are taken for those at their instants, with straight lines between them, so that the hold of the
input (half a sample) is part of the delay. All columns go through the same zero-phase filter; velocities and accelerations come
from a spline through positions that are filtered at three times its frequency. Needs numpy and scipy.
"""

import sys

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize
from scipy.signal import butter, sosfiltfilt

DT = 1e-3
ENDS = slice(200, -200)


def problem(data, bandwidth, delay, speed):
    """Columns and force, filtered; without `speed` there is no concave law."""
    t = np.arange(len(data["q"])) * DT
    wide = butter(4, min(3 * bandwidth, 400) * 2 * DT, output="sos")
    q = CubicSpline(t, sosfiltfilt(wide, data["q"]))
    v = q(t, 1)
    columns = [q(t, 2), v, np.sign(v), np.ones_like(v), np.abs(v)]
    if speed is not None:
        columns.append(np.sign(v) * np.exp(-np.abs(v) / speed))
    narrow = butter(4, bandwidth * 2 * DT, output="sos")
    force = np.interp(t - delay, t, data["force"])
    return sosfiltfilt(narrow, np.stack(columns, 1), axis=0)[ENDS], sosfiltfilt(narrow, force)[ENDS]


def error(data, bandwidth, delay, speed, values=None):
    """Relative force error, and the values that least squares give."""
    columns, force = problem(data, bandwidth, delay, speed)
    if values is None:
        values = np.linalg.lstsq(columns, force, rcond=None)[0]
    return np.linalg.norm(force - columns @ values) / np.linalg.norm(force), values


fit, held_out = (np.genfromtxt(name, delimiter=",", names=True) for name in sys.argv[1:3])
print("law        up to Hz   delay ms   force error %   held out %")
for concave in (False, True):
    for bandwidth in (20, 40, 60, 100):
        shape = lambda p: np.exp(p[1]) if concave else None
        start = [0.6, np.log(0.01)] if concave else [0.6]
        best = minimize(lambda p: error(fit, bandwidth, 1e-3 * p[0], shape(p))[0], start, method="Nelder-Mead").x
        own, values = error(fit, bandwidth, 1e-3 * best[0], shape(best))
        other, _ = error(held_out, bandwidth, 1e-3 * best[0], shape(best), values)
        name = "concave" if concave else "straight"
        print(f"{name:10} {bandwidth:8} {best[0]:10.2f} {100 * own:15.2f} {100 * other:12.2f}")
