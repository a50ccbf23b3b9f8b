"""Statistics of data: rows are observations."""

import math

import numpy as np

import vividc

V, M = "float32[::1]", "float32[:, ::1]"


@vividc.kernel(f"void(float32, {M}, {M}, {V}, {V})")
def correlation(float_n, data, corr, mean, stddev):
    """Correlations of the columns, float_n of them rows."""
    n, m = data.shape
    for j in range(m):
        mean[j] = np.float32(0.0)
        for i in range(n):
            mean[j] += data[i, j]
        mean[j] /= float_n
    for j in range(m):
        stddev[j] = np.float32(0.0)
        for i in range(n):
            stddev[j] += (data[i, j] - mean[j]) * (data[i, j] - mean[j])
        stddev[j] /= float_n
        stddev[j] = math.sqrt(stddev[j])
        if stddev[j] <= np.float32(0.1):
            stddev[j] = np.float32(1.0)
    for i in range(n):
        for j in range(m):
            data[i, j] -= mean[j]
            data[i, j] /= math.sqrt(float_n) * stddev[j]
    for i in range(m - 1):
        corr[i, i] = np.float32(1.0)
        for j in range(i + 1, m):
            corr[i, j] = np.float32(0.0)
            for k in range(n):
                corr[i, j] += data[k, i] * data[k, j]
            corr[j, i] = corr[i, j]
    corr[m - 1, m - 1] = np.float32(1.0)


@vividc.kernel(f"void(float32, {M}, {M}, {V})")
def covariance(float_n, data, cov, mean):
    """Covariances of the columns."""
    n, m = data.shape
    for j in range(m):
        mean[j] = np.float32(0.0)
        for i in range(n):
            mean[j] += data[i, j]
        mean[j] /= float_n
    for i in range(n):
        for j in range(m):
            data[i, j] -= mean[j]
    for i in range(m):
        for j in range(i, m):
            cov[i, j] = np.float32(0.0)
            for k in range(n):
                cov[i, j] += data[k, i] * data[k, j]
            cov[i, j] /= float_n - np.float32(1.0)
            cov[j, i] = cov[i, j]
