"""What stands between the networks of Instant-NGP (Mueller et al. 2022): the density from the first
network's outputs, the inputs of the second, the colour.

Networks have blocks of 16 samples, [block, feature, sample]; else they lie by block, sample and
feature.
"""

import math

import numpy as np

import vividc

ONE = np.float32(1.0)
LARGEST = np.float32(80.0)

# Degree 4 (16 values) in the order and signs of tiny-cuda-nn.
Y0 = np.float32(0.28209479177387814)
Y1 = np.float32(0.48860251190291987)
Y2_XY = np.float32(1.0925484305920792)
Y2_ZZ = np.float32(0.94617469575755997)
Y2_Z0 = np.float32(0.31539156525251999)
Y2_XX = np.float32(0.54627421529603959)
Y3_XXY = np.float32(0.59004358992664352)
Y3_XYZ = np.float32(2.8906114426405538)
Y3_YZZ = np.float32(0.45704579946446572)
Y3_ZZZ = np.float32(0.3731763325901154)
Y3_XXZ = np.float32(1.4453057213202769)
THREE = np.float32(3.0)
FIVE = np.float32(5.0)


@vividc.kernel("void(float32[:, :, ::1], float32, float32, float32[:, ::1], float32[:, :, ::1])")
def density(x, limit, step, thickness, features):
    """Optical thickness of a step, exp of the first output, clamped; and all outputs by sample."""
    for block in range(x.shape[0]):
        for sample in range(16):
            for feature in range(features.shape[2]):
                features[block, sample, feature] = x[block, feature, sample]
    for block in range(x.shape[0]):
        for sample in range(16):
            thickness[block, sample] = math.exp(min(x[block, 0, sample], limit)) * step


@vividc.kernel("void(float32[:, :, ::1], float32[:, :, ::1], float32[:, :, ::1])")
def colour_inputs(features, directions, out):
    """16 spherical harmonics of the unit directions, then the features."""
    for block in range(out.shape[0]):
        for sample in range(16):
            x = directions[block, sample, 0]
            y = directions[block, sample, 1]
            z = directions[block, sample, 2]
            xy = x * y
            xx = x * x
            yy = y * y
            zz = z * z
            out[block, 0, sample] = Y0
            out[block, 1, sample] = -Y1 * y
            out[block, 2, sample] = Y1 * z
            out[block, 3, sample] = -Y1 * x
            out[block, 4, sample] = Y2_XY * xy
            out[block, 5, sample] = -Y2_XY * (y * z)
            out[block, 6, sample] = Y2_ZZ * zz - Y2_Z0
            out[block, 7, sample] = -Y2_XY * (x * z)
            out[block, 8, sample] = Y2_XX * (xx - yy)
            out[block, 9, sample] = Y3_XXY * y * (yy - THREE * xx)
            out[block, 10, sample] = Y3_XYZ * xy * z
            out[block, 11, sample] = Y3_YZZ * y * (ONE - FIVE * zz)
            out[block, 12, sample] = Y3_ZZZ * z * (FIVE * zz - THREE)
            out[block, 13, sample] = Y3_YZZ * x * (ONE - FIVE * zz)
            out[block, 14, sample] = Y3_XXZ * z * (xx - yy)
            out[block, 15, sample] = Y3_XXY * x * (THREE * yy - xx)
    for block in range(out.shape[0]):
        for sample in range(16):
            for feature in range(features.shape[2]):
                out[block, feature + 16, sample] = features[block, sample, feature]


@vividc.kernel("void(float32[:, :, ::1], float32[:, :, ::1])")
def colour(x, out):
    """Sigmoids of the first three outputs."""
    for block in range(x.shape[0]):
        for sample in range(16):
            for channel in range(3):
                exponent = min(max(-x[block, channel, sample], -LARGEST), LARGEST)
                out[block, sample, channel] = ONE / (ONE + math.exp(exponent))
