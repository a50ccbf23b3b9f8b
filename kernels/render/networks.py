"""The small networks of neural rendering: a layer, and the functions after it."""

import math

import numpy as np

import vividc

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
LARGE = np.float32(20.0)


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[::1], float32[:, ::1])")
def dense_relu(inputs, weights, bias, out):
    """out = max(0, inputs weights^T + bias); `weights` are [outputs, inputs]."""
    for sample in range(inputs.shape[0]):
        for neuron in range(weights.shape[0]):
            total = bias[neuron]
            for k in range(weights.shape[1]):
                total += weights[neuron, k] * inputs[sample, k]
            out[sample, neuron] = max(total, ZERO)


@vividc.kernel("void(float32[::1])")
def sigmoid(x):
    """1 / (1 + exp(-x)) in place."""
    for i in range(len(x)):
        x[i] = ONE / (ONE + math.exp(-x[i]))


@vividc.kernel("void(float32[::1], float32, float32[::1])")
def softplus(features, shift, density):
    """log(1 + exp(x + shift)), which is x + shift where that is large."""
    for i in range(len(features)):
        x = features[i] + shift
        if x > LARGE:
            density[i] = x
        else:
            density[i] = math.log1p(math.exp(x))


@vividc.kernel("void(float32[:, ::1], float32, float32[::1])")
def exponential_density(features, limit, density):
    """exp of the first feature of each sample, clamped."""
    for i in range(features.shape[0]):
        density[i] = math.exp(min(features[i, 0], limit))
