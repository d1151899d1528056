"""Writes welch.csv: densities by scipy.signal.welch of records that tests/library/spectrum.rs makes too.

Run it beside the file: python welch.py > welch.csv
"""

import numpy as np
from scipy.signal import welch

RATE_HZ = 100.0
CASES = [(600, 64, "constant"), (600, 65, "linear"), (300, 300, "constant")]


def record(samples):
    """Numbers of the generator of Lehmer between -1 and 1, on a ramp."""
    state, values = 1_234_567_890, []
    for i in range(samples):
        state = 16807 * state % 2_147_483_647
        values.append(2.0 * state / 2_147_483_647.0 - 1.0 + 0.01 * i)
    return np.array(values)


print("samples,segment,detrend,f_hz,density")
for samples, segment, detrend in CASES:
    densities = welch(record(samples), RATE_HZ, nperseg=segment, detrend=detrend)
    for f, density in list(zip(*densities))[1:]:
        print(f"{samples},{segment},{detrend},{float(f)!r},{float(density)!r}")
