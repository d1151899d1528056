"""Makes base_vibration.csv: twelve seconds of the angular rate of a base under a rotor, at 500 Hz.

    python3 studies/data/make_base_vibration.py > studies/data/base_vibration.csv

Two tones of a rotor whose amplitudes and phases wander, a broadband floor that falls above 60 Hz, and two bumps. Invented,
not measured. Needs NumPy; another version of it may draw other numbers.
"""

import numpy as np

SEED = 20
RATE_HZ = 500
SECONDS = 12
# Frequency in Hz, amplitude of the rate in deg/s, the relative size of its wandering.
TONES = [(19.3, 3.0, 0.25), (41.0, 1.2, 0.4)]
FLOOR_DEG_PER_S = 0.15
# Time of the start in s, peak in deg/s, ringing in Hz, decay in s.
BUMPS = [(3.1, 6.0, 11.0, 0.12), (8.45, -4.0, 14.0, 0.09)]


def low_passed(noise, corner_hz):
    """The noise below a first-order corner, with a standard deviation of 1."""
    spectrum = np.fft.rfft(noise)
    spectrum /= 1 + 1j * np.fft.rfftfreq(noise.size, 1 / RATE_HZ) / corner_hz
    spectrum[0] = 0
    filtered = np.fft.irfft(spectrum, noise.size)
    return filtered / filtered.std()


def base_rate(time, generator):
    rate = FLOOR_DEG_PER_S * low_passed(generator.standard_normal(time.size), 60)
    for frequency, amplitude, wander in TONES:
        envelope = amplitude * (1 + wander * low_passed(generator.standard_normal(time.size), 0.3))
        phase = 0.5 * low_passed(generator.standard_normal(time.size), 0.2)
        start = generator.uniform(0, 2 * np.pi)
        rate += envelope * np.sin(2 * np.pi * frequency * time + phase + start)
    for start, peak, ringing, decay in BUMPS:
        since = np.maximum(time - start, 0)
        # sin begins at 0, so that the record has no jump that 500 Hz could not show.
        rate += peak * np.exp(-since / decay) * np.sin(2 * np.pi * ringing * since)
    return rate


def main():
    time = np.arange(SECONDS * RATE_HZ) / RATE_HZ
    rate = base_rate(time, np.random.Generator(np.random.PCG64(SEED)))
    print("# Angular rate of a base under a rotor: tones at 19.3 Hz and 41 Hz of wandering amplitude, a broadband")
    print("# floor, bumps at 3.1 s and 8.45 s. An invented example, 12 s at 500 Hz, not a measurement.")
    print(f"# Made by studies/data/make_base_vibration.py with seed {SEED}.")
    print("time [s],rate [deg/s]")
    for t, r in zip(time, rate):
        print(f"{t:.3f},{r:.4f}")


if __name__ == "__main__":
    main()
