"""Makes golden.json: line measures of two small volumes by scikit-image and ITK, for tests/rootness_golden.rs.

    pip install numpy scikit-image itk
    python3 tests/data/rootness/golden.py
"""

import json
from pathlib import Path

import itk
import numpy as np
import skimage
from skimage.filters import sato

SIDE, SIGMA, INNER = 28, 2.0, slice(11, 17)


def noise():
    """Bytes 0..255 of a linear congruential generator, as (z, y, x)."""
    state, values = 1, []
    for _ in range(SIDE**3):
        state = (state * 1664525 + 1013904223) % 2**32
        values.append(state >> 24)
    return np.array(values, np.float32).reshape(SIDE, SIDE, SIDE)


def rod():
    """A bright rod along z of elliptic section: along it the least curvature is none."""
    z, y, x = np.mgrid[:SIDE, :SIDE, :SIDE] - (SIDE - 1) / 2
    return (100 * np.exp(-(x**2) / (2 * 1.5**2) - y**2 / (2 * 3.0**2)) + 0 * z).astype(np.float32)


def vesselness(volume):
    """ITK's measure, times the square of sigma as everybody else's."""
    hessian = itk.hessian_recursive_gaussian_image_filter(itk.image_from_array(volume), sigma=SIGMA)
    measure = itk.Hessian3DToVesselnessMeasureImageFilter[itk.F].New(hessian)
    measure.Update()
    return itk.array_from_image(measure.GetOutput()) * SIGMA**2


def rows(volume):
    return [round(float(v), 5) for v in volume[INNER, INNER, INNER].ravel()]


golden = {
    "made_by": {"scikit-image": skimage.__version__, "itk": itk.Version.GetITKVersion()},
    "side": SIDE,
    "sigma": SIGMA,
    "inner": [INNER.start, INNER.stop],
    "noise_scikit_image": rows(sato(noise(), sigmas=[SIGMA], black_ridges=False, mode="reflect")),
    "rod_scikit_image": rows(sato(rod(), sigmas=[SIGMA], black_ridges=False, mode="reflect")),
    "rod_itk": rows(vesselness(rod())),
}
Path(__file__).with_name("golden.json").write_text(json.dumps(golden) + "\n")
