/* Filters and stencils. */

#define TAPS 8

void fir(const int *x, const int *h, int *y, int n)
{
    for (int i = 0; i + TAPS <= n; i++) {
        int sum = 0;
        for (int t = 0; t < TAPS; t++)
            sum += x[i + t] * h[t];
        y[i] = sum;
    }
}

struct biquad {
    float b0, b1, b2, a1, a2;
    float z1, z2;
};

/* Transposed direct form II; the state is kept from call to call. */
void biquad(struct biquad *f, const float *x, float *y, int n)
{
    for (int i = 0; i < n; i++) {
        float in = x[i];
        float out = f->b0 * in + f->z1;
        f->z1 = f->b1 * in - f->a1 * out + f->z2;
        f->z2 = f->b2 * in - f->a2 * out;
        y[i] = out;
    }
}

/* One sweep of a five-point stencil over the inside of a picture. */
void jacobi2d(int h, int w, const float *restrict in, float *restrict out)
{
    for (int y = 1; y < h - 1; y++)
        for (int x = 1; x < w - 1; x++) {
            const float *p = in + y * w + x;
            out[y * w + x] = 0.2f * (p[0] + p[-1] + p[1] + p[-w] + p[w]);
        }
}

/* Exclusive; returns the total. */
int prefix_sum(int *x, int n)
{
    int sum = 0;
    for (int *p = x, *end = x + n; p != end; p++) {
        int value = *p;
        *p = sum;
        sum += value;
    }
    return sum;
}
