"""Matrix times vector plus bias, through a ReLU: one layer of an MLP for one input."""

import numpy as np

import vividc


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[::1], float32[::1])")
def relu_gemv(weights, x, bias, y):
    for i in range(weights.shape[0]):
        total = bias[i]
        for j in range(weights.shape[1]):
            total += weights[i, j] * x[j]
        y[i] = max(total, np.float32(0.0))
