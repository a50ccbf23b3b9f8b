"""Bytes, halves and flags as files, cameras and sound cards deliver them."""

import numpy as np

import vividc

CRC8_POLYNOMIAL = 0x07
ADLER_MODULUS = 65521
LONGEST_RUN = 255
CONTINUATION = 0x80
LOUDEST = 32767
SOFTEST = -32768
NINTH = 7282  # 1/9 in 16 fractional bits


@vividc.kernel("void(uint8[:, :, ::1], uint8[:, ::1])")
def grayscale(rgb, gray):
    """Luma of packed RGB, by ITU-R BT.601 in eighths of a byte."""
    for y in range(rgb.shape[0]):
        for x in range(rgb.shape[1]):
            luma = 77 * rgb[y, x, 0] + 150 * rgb[y, x, 1] + 29 * rgb[y, x, 2]
            gray[y, x] = (luma + 128) >> 8


@vividc.kernel("void(uint8[:, ::1], int32[::1])")
def gray_histogram(image, counts):
    """How often each gray level occurs."""
    for y in range(image.shape[0]):
        for x in range(image.shape[1]):
            counts[image[y, x]] += 1


@vividc.kernel("int32(uint8[::1], uint8, boolean[::1])")
def threshold_mask(pixels, level, mask):
    """Marks the pixels above the level; how many there are."""
    above = 0
    for i in range(pixels.shape[0]):
        mask[i] = pixels[i] > level
        above += mask[i]
    return np.int32(above)


@vividc.kernel("void(uint8[:, ::1], uint8[:, ::1])")
def box_blur(image, out):
    """Mean of 3x3 pixels, rounded; the border stays as it is."""
    for y in range(1, image.shape[0] - 1):
        for x in range(1, image.shape[1] - 1):
            total = np.int32(0)
            for dy in range(-1, 2):
                total += np.int32(image[y + dy, x - 1])
                total += np.int32(image[y + dy, x])
                total += np.int32(image[y + dy, x + 1])
            out[y, x] = (total * NINTH + 32768) >> 16


@vividc.kernel("void(uint8[::1], uint8[::1], uint8[::1])")
def blend_over(below, above, alpha):
    """Draws `above` over `below`, in place; the division by 255 is exact."""
    for i in range(below.shape[0]):
        mix = above[i] * alpha[i] + below[i] * (255 - alpha[i]) + 128
        below[i] = (mix + (mix >> 8)) >> 8


@vividc.kernel("int32(uint8[::1], uint8[::1])")
def run_length_encode(data, out):
    """Pairs of (length up to 255, byte); how many bytes were written."""
    written = 0
    i = 0
    while i < data.shape[0]:
        length = 1
        while i + length < data.shape[0] and length < LONGEST_RUN and data[i + length] == data[i]:
            length += 1
        out[written] = length
        out[written + 1] = data[i]
        written += 2
        i += length
    return np.int32(written)


@vividc.kernel("uint8(uint8[::1])")
def crc8(data):
    """CRC-8/SMBUS, bit by bit."""
    crc = np.uint8(0)
    for i in range(data.shape[0]):
        crc ^= data[i]
        for _ in range(8):
            top = crc & 0x80
            crc = np.uint8(crc << 1)
            if top != 0:
                crc ^= np.uint8(CRC8_POLYNOMIAL)
    return crc


@vividc.kernel("uint32(uint8[::1])")
def adler32_bytes(data):
    """The checksum of zlib (RFC 1950)."""
    a = np.uint32(1)
    b = np.uint32(0)
    for i in range(data.shape[0]):
        a = np.uint32(a + data[i])
        if a >= ADLER_MODULUS:
            a = np.uint32(a - ADLER_MODULUS)
        b = np.uint32(b + a)
        if b >= ADLER_MODULUS:
            b = np.uint32(b - ADLER_MODULUS)
    return np.uint32(b << 16 | a)


@vividc.kernel("int32(uint8[::1])")
def utf8_length(text):
    """Characters of well-formed UTF-8: every byte but the continuations."""
    characters = 0
    for i in range(text.shape[0]):
        if text[i] & 0xC0 != CONTINUATION:
            characters += 1
    return np.int32(characters)


@vividc.kernel("void(int16[::1], int16[::1], int16[::1])")
def mix_pcm(left, right, out):
    """Adds two tracks; what is too loud is clipped."""
    for i in range(out.shape[0]):
        out[i] = min(max(left[i] + right[i], SOFTEST), LOUDEST)


@vividc.kernel("void(int16[::1])")
def delta_decode(samples):
    """Differences to samples, in place; sums wrap at 16 bits."""
    for i in range(1, samples.shape[0]):
        samples[i] += samples[i - 1]


@vividc.kernel("void(uint8[:, ::1], int16[:, ::1], int16[:, ::1])")
def sobel_gradients(image, gx, gy):
    """Horizontal and vertical derivative of the inner pixels."""
    for y in range(1, image.shape[0] - 1):
        for x in range(1, image.shape[1] - 1):
            right = image[y - 1, x + 1] + 2 * image[y, x + 1] + image[y + 1, x + 1]
            left = image[y - 1, x - 1] + 2 * image[y, x - 1] + image[y + 1, x - 1]
            below = image[y + 1, x - 1] + 2 * image[y + 1, x] + image[y + 1, x + 1]
            above = image[y - 1, x - 1] + 2 * image[y - 1, x] + image[y - 1, x + 1]
            gx[y, x] = right - left
            gy[y, x] = below - above


@vividc.kernel("int32(boolean[:, ::1], boolean[:, ::1])")
def grow_region(region, mask):
    """Fills the parts of the mask that touch the region, by its four neighbours; how many sweeps
    it took.
    """
    sweeps = 0
    changed = True
    while changed:
        changed = False
        for y in range(1, mask.shape[0] - 1):
            for x in range(1, mask.shape[1] - 1):
                near = region[y - 1, x] | region[y + 1, x] | region[y, x - 1] | region[y, x + 1]
                if near and mask[y, x] and not region[y, x]:
                    region[y, x] = True
                    changed = True
        sweeps += 1
    return np.int32(sweeps)


@vividc.kernel("void(uint8[::1], uint8[::1])")
def apply_curve(pixels, curve):
    """Tone curve by table, in place."""
    for i in range(pixels.shape[0]):
        pixels[i] = curve[pixels[i]]


@vividc.kernel("void(uint16[::1])")
def swap_bytes(samples):
    """Big-endian to little-endian, in place."""
    for i in range(samples.shape[0]):
        samples[i] = samples[i] << 8 | samples[i] >> 8


@vividc.kernel("int32(uint8[::1], uint8[::1], uint8[::1])")
def base64_encode(data, alphabet, text):
    """Whole groups of three bytes as four characters; how many characters."""
    groups = (data.shape[0] * 43691) >> 17  # a third
    for g in range(groups):
        bits = data[3 * g] << 16 | data[3 * g + 1] << 8 | data[3 * g + 2]
        text[4 * g] = alphabet[bits >> 18]
        text[4 * g + 1] = alphabet[bits >> 12 & 63]
        text[4 * g + 2] = alphabet[bits >> 6 & 63]
        text[4 * g + 3] = alphabet[bits & 63]
    return np.int32(4 * groups)


@vividc.kernel("void(int8[:, ::1], int8[::1], int32[::1], int8, int8[::1])")
def quantised_layer(weights, inputs, bias, shift, out):
    """A layer of a network in int8: products summed in int32, scaled, clipped at 0 and 127."""
    for row in range(weights.shape[0]):
        total = bias[row]
        for column in range(inputs.shape[0]):
            total += np.int32(weights[row, column]) * np.int32(inputs[column])
        out[row] = min(max(np.int32(total) >> np.int32(shift), 0), 127)


@vividc.kernel("int8(int8[::1])")
def loudest(samples):
    """The largest sample."""
    best = samples[0]
    for i in range(1, samples.shape[0]):
        best = max(best, samples[i])
    return best


@vividc.kernel("void(int16[::1], float32, float32[::1])")
def pcm_to_float(samples, gain, out):
    """Samples as fractions of full scale."""
    for i in range(samples.shape[0]):
        out[i] = np.float32(samples[i]) * gain
