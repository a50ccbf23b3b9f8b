"""Edge detection, shortest paths, and the folding of RNA."""

import math

import numpy as np

import vividc

M = "float32[:, ::1]"
ONE, TWO = np.float32(1.0), np.float32(2.0)
PAIR = 3  # the bases of a pair add up to it


@vividc.kernel(f"void(float32, {M}, {M}, {M}, {M})")
def deriche(alpha, image, out, y1, y2):
    """Deriche's recursive smoothing, along rows and then along columns."""
    w, h = image.shape
    decay = math.exp(-alpha)
    k = (ONE - decay) * (ONE - decay) / (ONE + TWO * alpha * decay - math.exp(TWO * alpha))
    a1 = k
    a2 = k * decay * (alpha - ONE)
    a3 = k * decay * (alpha + ONE)
    a4 = -k * math.exp(-TWO * alpha)
    b1 = TWO**-alpha
    b2 = -math.exp(-TWO * alpha)
    for i in range(w):
        ym1 = np.float32(0.0)
        ym2 = np.float32(0.0)
        xm1 = np.float32(0.0)
        for j in range(h):
            y1[i, j] = a1 * image[i, j] + a2 * xm1 + b1 * ym1 + b2 * ym2
            xm1 = image[i, j]
            ym2 = ym1
            ym1 = y1[i, j]
    for i in range(w):
        yp1 = np.float32(0.0)
        yp2 = np.float32(0.0)
        xp1 = np.float32(0.0)
        xp2 = np.float32(0.0)
        for j in range(h - 1, -1, -1):
            y2[i, j] = a3 * xp1 + a4 * xp2 + b1 * yp1 + b2 * yp2
            xp2 = xp1
            xp1 = image[i, j]
            yp2 = yp1
            yp1 = y2[i, j]
    for i in range(w):
        for j in range(h):
            out[i, j] = y1[i, j] + y2[i, j]
    for j in range(h):
        tm1 = np.float32(0.0)
        ym1 = np.float32(0.0)
        ym2 = np.float32(0.0)
        for i in range(w):
            y1[i, j] = a1 * out[i, j] + a2 * tm1 + b1 * ym1 + b2 * ym2
            tm1 = out[i, j]
            ym2 = ym1
            ym1 = y1[i, j]
    for j in range(h):
        tp1 = np.float32(0.0)
        tp2 = np.float32(0.0)
        yp1 = np.float32(0.0)
        yp2 = np.float32(0.0)
        for i in range(w - 1, -1, -1):
            y2[i, j] = a3 * tp1 + a4 * tp2 + b1 * yp1 + b2 * yp2
            tp2 = tp1
            tp1 = out[i, j]
            yp2 = yp1
            yp1 = y2[i, j]
    for i in range(w):
        for j in range(h):
            out[i, j] = y1[i, j] + y2[i, j]


@vividc.kernel("void(int32[:, ::1])")
def floyd_warshall(paths):
    """Shortest paths between all nodes, in place."""
    n = paths.shape[0]
    for k in range(n):
        for i in range(n):
            for j in range(n):
                paths[i, j] = min(paths[i, j], paths[i, k] + paths[k, j])


@vividc.kernel("void(int32[::1], int32[:, ::1])")
def nussinov(seq, table):
    """Most pairs of bases that a folded sequence has."""
    n = len(seq)
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            if j - 1 >= 0:
                table[i, j] = max(table[i, j], table[i, j - 1])
            if i + 1 < n:
                table[i, j] = max(table[i, j], table[i + 1, j])
            if j - 1 >= 0 and i + 1 < n:
                if i < j - 1:
                    match = 1 if seq[i] + seq[j] == PAIR else 0
                    table[i, j] = max(table[i, j], table[i + 1, j - 1] + match)
                else:
                    table[i, j] = max(table[i, j], table[i + 1, j - 1])
            for k in range(i + 1, j):
                table[i, j] = max(table[i, j], table[i, k] + table[k + 1, j])
