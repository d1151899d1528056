"""Public logs of gyros at rest: fetches them, makes them readable, and reads their Allan deviations with AllanTools.

    pip install allantools rdata
    python3 benches/public_logs.py [FOLDER]

The logs are fetched from the commits below into FOLDER (results/public_logs) and compared with their SHA-256. Data sets of R become .npz
with the arrays gx, gy, gz (and ax, ay, az); `rdata` reads them, because an .rda file is a serialized and compressed object of R. Then each gyro
gets one line that is independent of sagnac: N = σ(τ) √τ at the τ next to 1 s, and B = σ / 0.664 at the minimum of the overlapping Allan
deviation over octaves of τ up to a fifth of the record. docs/dev/public-logs.md compares them with what sagnac finds.

The variable PUBLIC_LOGS replaces https://github.com, as in PUBLIC_LOGS=file:///srv/mirror, where the files lie under the same paths.
The licences are those of the owners, who are named in docs/dev/public-logs.md; nothing of the logs is part of sagnac.
"""

import hashlib
import os
import sys
import urllib.parse
import urllib.request
import warnings
from pathlib import Path

import allantools
import numpy
import rdata

IMUDATA = "SMAC-Group/imudata/raw/eec6e5b627a31a4a1c286e0d1475c6556705b2a6/data/"
ALLAN_VARIANCE = "milkytipo/Allan-variance/raw/4ab814e749bbfc8827cbbd6a8634ca7abf4822fc/"
DEGREES = 3600.0
RADIANS = numpy.degrees(3600.0)

# Name here, path on the server, SHA-256, samples a second, degrees an hour in the unit of the rates, columns of the rates in a text.
LOGS = [
    (f"adis16405_{k}.npz", f"{IMUDATA}adis_16405_imu{k}.rda", digest, 100.0, DEGREES, None)
    for k, digest in enumerate(
        [
            "1eb09074beabd7cfc15b402cb8043b5302f6e4edfd9e4ebfbf8117436f8b9fa9",
            "de95fc0bcf854b3bcbda77e176841dcd4ec389d2676ba814d4f54dcdbe460fc0",
            "aaf972eb6ded35bad4ad2d46c44b0bfefd6665d485aabec4a417fc14259c18af",
            "6f1dd1f5d3fd565ead7ad0d45e0d89d058dc3498cde0c7984702ef89333205d4",
            "4967b52057106ebf0960f81f08fc47ac1bdd96ce842a802b8ee5fceecac8d8ee",
            "58d35eae5c930fba9ae2110d90c14328c4ed29c71d943f757d1b941f412b3115",
        ],
        start=1,
    )
] + [
    (
        "mtig.npz",
        IMUDATA + "cont.imu1.rda",
        "0c177912a952df1142d847373e3fa7030129d6b42ef1ecad56f507ba3aaf01f6",
        100.0,
        RADIANS,
        None,
    ),
    (
        "ig500n.txt",
        ALLAN_VARIANCE + "静置2.44小时-2018-3-29_IG-500N_007000927.txt",
        "ed4078b3b08ea8c3026ac155295089ce2bb0f5ce367aa3972e9c8b244951f8d4",
        100.0 / 24.0,
        DEGREES,
        {"gx": 6, "gy": 7, "gz": 8},
    ),
]


def fetch(path, digest, file):
    if not file.exists():
        base = os.environ.get("PUBLIC_LOGS", "https://github.com")
        address = f"{base}/{urllib.parse.quote(path)}"
        try:
            with urllib.request.urlopen(address) as answer:
                file.write_bytes(answer.read())
        except OSError as error:
            sys.exit(f"{address}: {error}; put the file into {file.parent} as {file.name} by other means, or set PUBLIC_LOGS")
    found = hashlib.sha256(file.read_bytes()).hexdigest()
    if found != digest:
        sys.exit(f"{file} has the SHA-256 {found} instead of {digest}: delete it and try again")


def columns(file):
    """The columns of the only matrix in an .rda file, under the names gx … az."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # rdata has no constructor for the class "imu" and says so; the matrix is what is wanted
        (matrix,) = rdata.read_rda(file).values()
    names = [name.replace("Gyro. ", "g").replace("Accel. ", "a").lower() for name in matrix.coords["dim_1"].values]
    return dict(zip(names, numpy.asarray(matrix).T.copy()))


def reading(rate, step):
    """N in °/√h, and the minimum of the curve with its τ, of a rate in °/h."""
    taus = [2**k * step for k in range(30) if 2**k <= len(rate) // 5]
    taus, deviations, _, _ = allantools.oadev(rate, rate=1.0 / step, data_type="freq", taus=taus)
    second = abs(numpy.log(taus)).argmin()
    lowest = deviations.argmin()
    return deviations[second] * taus[second] ** 0.5 / 60.0, deviations[lowest], taus[lowest]


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/public_logs")
    folder.mkdir(parents=True, exist_ok=True)
    print("log               gyro  N, °/√h  minimum, °/h   at τ, s   B, °/h")
    for name, path, digest, rate, unit, texts in LOGS:
        source = folder / (name if texts else Path(path).name)
        fetch(path, digest, source)
        if texts:
            rows = numpy.loadtxt(source)
            arrays = {gyro: rows[:, column] for gyro, column in texts.items()}
        else:
            arrays = columns(source)
            numpy.savez(folder / name, **arrays)
        for gyro in ["gx", "gy", "gz"]:
            if gyro in arrays:
                n, lowest, tau = reading(arrays[gyro] * unit, 1.0 / rate)
                print(f"{name:18}{gyro:4}{n:9.3f}{lowest:14.2f}{tau:10.1f}{lowest / 0.664:9.2f}", flush=True)


main()
