"""Kernels with division and elementary functions."""

import math

import numpy as np

import vividc


@vividc.kernel("void(float32[::1])")
def normalise(x):
    square = np.float32(0)
    for i in range(len(x)):
        square += x[i] * x[i]
    scale = np.float32(1) / math.sqrt(square)
    for i in range(len(x)):
        x[i] *= scale


@vividc.kernel("float32(float32[::1])")
def mean(x):
    total = np.float32(0)
    for i in range(len(x)):
        total += x[i]
    return total / np.float32(len(x))


@vividc.kernel("void(float32[::1])")
def sigmoid(x):
    for i in range(len(x)):
        x[i] = np.float32(1) / (np.float32(1) + math.exp(-x[i]))


@vividc.kernel("void(float32[::1])")
def fraction(x):
    for i in range(len(x)):
        x[i] = (x[i] - np.floor(x[i])) / (np.ceil(x[i] * x[i]) + np.float32(1))


@vividc.kernel("void(float32[::1])")
def softmax(x):
    top = x[0]
    for i in range(len(x)):
        top = max(top, x[i])
    total = np.float32(0)
    for i in range(len(x)):
        x[i] = math.exp(x[i] - top)
        total += x[i]
    scale = np.float32(1) / total
    for i in range(len(x)):
        x[i] *= scale


INVARIANT = (normalise, mean, softmax)
EVERY_ITERATION = (sigmoid, fraction)
