/* Dense linear algebra, as in PolyBench. */

void gemm(int ni, int nj, int nk, float alpha, float beta, float *restrict c,
          const float *restrict a, const float *restrict b)
{
    for (int i = 0; i < ni; i++) {
        for (int j = 0; j < nj; j++)
            c[i * nj + j] *= beta;
        for (int k = 0; k < nk; k++)
            for (int j = 0; j < nj; j++)
                c[i * nj + j] += alpha * a[i * nk + k] * b[k * nj + j];
    }
}

/* y = A^T (A x) */
void atax(int m, int n, float a[m][n], float *x, float *y, float *tmp)
{
    for (int j = 0; j < n; j++)
        y[j] = 0;
    for (int i = 0; i < m; i++) {
        tmp[i] = 0;
        for (int j = 0; j < n; j++)
            tmp[i] += a[i][j] * x[j];
        for (int j = 0; j < n; j++)
            y[j] += a[i][j] * tmp[i];
    }
}

void mvt(int n, float *x1, float *x2, const float *y1, const float *y2, float a[n][n])
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            x1[i] = x1[i] + a[i][j] * y1[j];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            x2[i] = x2[i] + a[j][i] * y2[j];
}

void transpose(int *a, int n)
{
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++) {
            int t = a[i * n + j];
            a[i * n + j] = a[j * n + i];
            a[j * n + i] = t;
        }
}

/* Solves L x = b for a lower triangular L. */
void trisolv(int n, const float *l, float *x, const float *b)
{
    for (int i = 0; i < n; i++) {
        float sum = b[i];
        for (int j = 0; j < i; j++)
            sum -= l[i * n + j] * x[j];
        x[i] = sum / l[i * n + i];
    }
}
