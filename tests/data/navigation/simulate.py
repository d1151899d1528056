"""Independent simulations of a navigator with gyro errors, for tests/library/navigation.rs.

responses.csv: the full, nonlinear equations of a strapdown in local-level axes (direction cosines, velocity, latitude and
longitude on a spherical, turning Earth), integrated by Runge and Kutta's method of fourth order with and without the error
of one gyro. A row has the start, the leg, the error of the gyro, a + b t + c sin(2 pi f t) in deg/h, and the differences.

noise.csv: the rms of the errors over many runs of the same equations, linearized by central differences of the full ones
and stepped by the exponential of their matrix, with white noise, a random walk or Markov noise on all three gyros, and the
standard error of each.

Needs NumPy and SciPy: python3 simulate.py
"""

import csv

import numpy as np
from scipy.linalg import expm

OMEGA = 7.292115e-5
RADIUS = 6.371e6
GRAVITY = 9.80665
ARCSEC = np.pi / 648000.0
# rad/s of 1 deg/h, which is 1 arcsec/s.
DEG_PER_H = ARCSEC
GYROS = ["north", "east", "down"]
ERRORS = ["heading_arcsec", "tilt_north_arcsec", "tilt_east_arcsec", "velocity_north_m_per_s",
          "velocity_east_m_per_s", "position_north_m", "position_east_m"]


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def rates(latitude, v):
    of_earth = OMEGA * np.array([np.cos(latitude), 0.0, -np.sin(latitude)])
    over_earth = np.array([v[1], -v[0], -v[1] * np.tan(latitude)]) / RADIUS
    return of_earth, over_earth


def truth(time, latitude, v):
    """Rates and specific force along true north, east and down on a leg of constant velocity."""
    of_earth, over_earth = rates(latitude + v[0] / RADIUS * time, v)
    force = np.cross(2 * of_earth + over_earth, np.append(v, 0.0)) - np.array([0, 0, GRAVITY])
    return of_earth + over_earth, force


def derivative(time, state, start, leg, error):
    """Of nine direction cosines, two velocities, latitude and longitude as the navigator computes them."""
    attitude, v, latitude = state[:9].reshape(3, 3), state[9:11], state[11]
    turning, force = truth(time, start, leg)
    of_earth, over_earth = rates(latitude, v)
    turned = attitude @ skew(turning + error(time)) - skew(of_earth + over_earth) @ attitude
    pushed = attitude @ force - np.cross(2 * of_earth + over_earth, np.append(v, 0.0))
    moved = [v[0] / RADIUS, v[1] / (RADIUS * np.cos(latitude))]
    return np.concatenate([turned.ravel(), pushed[:2], moved])


def integrated(duration, step, start, leg, error):
    state = np.concatenate([np.eye(3).ravel(), leg, [start, 0.0]])
    for k in range(round(duration / step)):
        t = k * step
        a = derivative(t, state, start, leg, error)
        b = derivative(t + step / 2, state + step / 2 * a, start, leg, error)
        c = derivative(t + step / 2, state + step / 2 * b, start, leg, error)
        d = derivative(t + step, state + step * c, start, leg, error)
        state = state + step / 6 * (a + 2 * b + 2 * c + d)
    return state


def errors(state, reference):
    attitude = state[:9].reshape(3, 3) @ reference[:9].reshape(3, 3).T
    latitude = reference[11]
    return np.array([attitude[1, 0] / ARCSEC, attitude[2, 1] / ARCSEC, attitude[0, 2] / ARCSEC,
                     *(state[9:11] - reference[9:11]), RADIUS * (state[11] - latitude),
                     RADIUS * np.cos(latitude) * (state[12] - reference[12])])


def responses():
    # Latitude deg, speed m/s, course deg, duration s; a deg/h, b deg/h/h, c deg/h, f Hz. The gyro errors are so small that
    # their squares are below the tolerance of the test.
    cases = [
        ((60.0, 0.0, 0.0, 3600.0), (1e-4, 0.0, 0.0, 0.0)),
        ((45.0, 0.0, 0.0, 21600.0), (1e-4, -4e-5, 0.0, 0.0)),
        ((-30.0, 0.0, 0.0, 36000.0), (0.0, 0.0, 2e-4, 1.0 / 3000.0)),
        ((50.0, 250.0, 90.0, 7200.0), (1e-4, 0.0, 0.0, 0.0)),
        ((40.0, 200.0, 40.0, 10800.0), (5e-5, 2e-5, 1e-4, 1.0 / 900.0)),
        ((10.0, 300.0, -120.0, 14400.0), (1e-4, -1e-5, 0.0, 0.0)),
    ]
    with open("responses.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["latitude_deg", "speed_m_per_s", "course_deg", "duration_s", "gyro", "a", "b", "c", "f_hz"] + ERRORS)
        for (latitude, speed, course, duration), (a, b, c, f) in cases:
            start = np.radians(latitude)
            leg = speed * np.array([np.cos(np.radians(course)), np.sin(np.radians(course))])
            # Any error of the integration itself is in both.
            reference = integrated(duration, 2.0, start, leg, lambda t: np.zeros(3))
            for axis, gyro in enumerate(GYROS):
                def error(t):
                    rate = np.zeros(3)
                    rate[axis] = (a + b * t / 3600.0 + c * np.sin(2 * np.pi * f * t)) * DEG_PER_H
                    return rate
                found = errors(integrated(duration, 2.0, start, leg, error), reference)
                out.writerow([latitude, speed, course, duration, gyro, a, b, c, repr(f)] + [f"{x:.9e}" for x in found])


def matrix(latitude):
    """A of the errors at rest, by central differences of the full equations."""
    def moved(place, by):
        attitude, state = np.zeros(3), np.concatenate([np.eye(3).ravel(), [0.0, 0.0, latitude, 0.0]])
        if place < 3:
            attitude[place] = by
            state[:9] = (np.eye(3) + skew(attitude)).ravel()
        elif place < 5:
            state[6 + place] = by
        elif place == 5:
            state[11] = latitude + by / RADIUS
        else:
            state[12] = by / (RADIUS * np.cos(latitude))
        rate = derivative(0.0, state, latitude, np.zeros(2), lambda t: np.zeros(3))
        turned = rate[:9].reshape(3, 3)
        return np.array([turned[2, 1], turned[0, 2], turned[1, 0], rate[9], rate[10], RADIUS * rate[11],
                         RADIUS * np.cos(latitude) * rate[12]])
    sizes = [1e-6] * 3 + [1e-2] * 2 + [1.0] * 2
    return np.array([(moved(i, s) - moved(i, -s)) / (2 * s) for i, s in enumerate(sizes)]).T


def noise():
    rng = np.random.default_rng(26)
    runs, step, latitude = 4000, 2.0, np.radians(60.0)
    a = matrix(latitude)
    wide = np.zeros((14, 14))
    wide[:7, :7], wide[:7, 7:] = a * step, np.eye(7) * step
    exponential = expm(wide)
    phi, gamma = exponential[:7, :7], exponential[:7, 7:10]
    with open("noise.csv", "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        header = [name for error in ERRORS for name in (error, error + "_se")]
        out.writerow(["noise", "size", "shape_s", "duration_s"] + header)
        for name, size, shape in [("angle_random_walk", 0.001 * 60.0, 0.0), ("rate_random_walk", 0.002 / 60.0, 0.0),
                                  ("markov", 0.005, 600.0)]:
            for duration in [3600.0, 14400.0]:
                state, rate = np.zeros((7, runs)), np.zeros((3, runs))
                decay = np.exp(-step / shape) if shape else 0.0
                if name == "markov":
                    rate = size * rng.standard_normal((3, runs))
                for k in range(round(duration / step)):
                    z = rng.standard_normal((3, runs))
                    if name == "angle_random_walk":
                        rate = size / np.sqrt(step) * z
                    elif name == "rate_random_walk":
                        rate = rate + size * np.sqrt(step) * z
                    elif k > 0:
                        rate = decay * rate + size * np.sqrt(1 - decay**2) * z
                    state = phi @ state + gamma @ (rate * DEG_PER_H)
                found = np.array([state[2] / ARCSEC, state[0] / ARCSEC, state[1] / ARCSEC, *state[3:]])
                square = found**2
                rms = np.sqrt(square.mean(axis=1))
                se = square.std(axis=1) / np.sqrt(runs) / (2 * rms)
                cells = [f"{x:.6e}" for pair in zip(rms, se) for x in pair]
                out.writerow([name, repr(size), shape, duration] + cells)


if __name__ == "__main__":
    responses()
    noise()
