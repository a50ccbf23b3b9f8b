/* Kernels beside a `main` that calls what no kernel may, as public suites have them. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern double seconds(void);
void prepare(void);

static void print(int n, const float *y) {
  for (int i = 0; i < n; i++)
    fprintf(stderr, "%0.2f ", y[i]);
}

void atax(int m, int n, const float *a, const float *x, float *y) {
  for (int j = 0; j < n; j++)
    y[j] = 0;
  for (int i = 0; i < m; i++) {
    float sum = 0;
    for (int j = 0; j < n; j++)
      sum += a[i * n + j] * x[j];
    for (int j = 0; j < n; j++)
      y[j] += a[i * n + j] * sum;
  }
}

void levinson(int n, const float *r, float *y, float *z) {
  float beta = 1, alpha = -r[0];
  y[0] = -r[0];
  for (int k = 1; k < n; k++) {
    float sum = r[k];
    beta *= 1 - alpha * alpha;
    for (int i = 0; i < k; i++)
      sum += r[k - i - 1] * y[i];
    alpha = -sum / beta;
    for (int i = 0; i < k; i++)
      z[i] = y[i] + alpha * y[k - i - 1];
    for (int i = 0; i < k; i++)
      y[i] = z[i];
    y[k] = alpha;
  }
}

void substitute(const uint8_t *in, uint8_t *out, int n) {
  static const uint8_t box[16] = "a$\\\xC2\x5c\"xyz\\\\\0;}";
  for (int i = 0; i < n; i++)
    out[i] = box[in[i] & 15];
}

int main(int argc, char **argv) {
  int n = 40;
  float *a = malloc(n * n * 4), *x = malloc(n * 4), *y = malloc(n * 4);
  prepare();
  atax(n, n, a, x, y);
  if (argc > 42 && !strcmp(argv[0], ""))
    print(n, y);
  printf("%f\n", seconds());
  free(y);
  return 0;
}
