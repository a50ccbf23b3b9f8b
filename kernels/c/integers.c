/* Integer and bit arithmetic. */

#include <stdint.h>

static uint32_t rotr(uint32_t x, int by)
{
    return x >> by | x << (32 - by);
}

/* Of words, least significant byte first, bit by bit. */
uint32_t crc32(const uint32_t *words, int n)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (int i = 0; i < n; i++) {
        crc ^= words[i];
        for (int bit = 0; bit < 32; bit++)
            crc = crc & 1 ? crc >> 1 ^ 0xEDB88320u : crc >> 1;
    }
    return ~crc;
}

/* Extends the first 16 of 64 words of the message schedule. */
void sha256_schedule(uint32_t *w)
{
    for (int i = 16; i < 64; i++) {
        uint32_t a = w[i - 15], b = w[i - 2];
        uint32_t s0 = rotr(a, 7) ^ rotr(a, 18) ^ a >> 3;
        uint32_t s1 = rotr(b, 17) ^ rotr(b, 19) ^ b >> 10;
        w[i] = w[i - 16] + s0 + w[i - 7] + s1;
    }
}

/* The 64 rounds on a state of eight words. */
void sha256_rounds(uint32_t *state, const uint32_t *w, const uint32_t *constants)
{
    uint32_t a = state[0], b = state[1], c = state[2], d = state[3];
    uint32_t e = state[4], f = state[5], g = state[6], h = state[7];
    for (int i = 0; i < 64; i++) {
        uint32_t s1 = rotr(e, 6) ^ rotr(e, 11) ^ rotr(e, 25);
        uint32_t t1 = h + s1 + ((e & f) ^ (~e & g)) + constants[i] + w[i];
        uint32_t s0 = rotr(a, 2) ^ rotr(a, 13) ^ rotr(a, 22);
        uint32_t t2 = s0 + ((a & b) ^ (a & c) ^ (b & c));
        h = g, g = f, f = e, e = d + t1;
        d = c, c = b, b = a, a = t1 + t2;
    }
    state[0] += a, state[1] += b, state[2] += c, state[3] += d;
    state[4] += e, state[5] += f, state[6] += g, state[7] += h;
}

/* Pixels of a row that stay within the circle of radius 2 for `limit` steps count `limit`. */
void mandelbrot(const float *re, float im, int *count, int n, int limit)
{
    for (int i = 0; i < n; i++) {
        float x = 0, y = 0;
        int k = 0;
        while (k < limit && x * x + y * y <= 4.0f) {
            float t = x * x - y * y + re[i];
            y = 2.0f * x * y + im;
            x = t;
            k++;
        }
        count[i] = k;
    }
}
