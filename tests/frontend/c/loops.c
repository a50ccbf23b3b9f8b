/* Loops as clang rotates them: each function takes an array of 16 words and two numbers. */

#include <string.h>

int up(int *a, int n, int m) { int s = 0; for (int i = m; i < n; i++) s += a[i & 15]; return s; }
int up_by_three(int *a, int n, int m) { int s = m; for (int i = 0; i < n; i += 3) s += a[i & 15]; return s; }
int down(int *a, int n, int m) { int s = 0; for (int i = n; i >= m; i--) s = s * 3 + a[i & 15]; return s; }
int closed(int *a, int n, int m) { int s = 0; for (int i = m; i <= n; i++) s ^= a[i & 15] + i; return s; }
int until(int *a, int n, int m) { int s = 0; for (int i = 0; i != (n & 15); i++) s += a[i] & m; return s; }
int at_least_once(int *a, int n, int m) { int i = m; do { a[i & 15] += i; } while (++i < n); return i; }
int unsigned_count(int *a, unsigned n, unsigned m) { int s = 0; for (unsigned i = m & 7; i < (n & 31); i++) s += a[i & 15]; return s; }
int first(int *a, int n, int m) { for (int i = 0; i < n; i++) if (a[i & 15] == m) return i; return -1; }
int last_value(int *a, int n, int m) { int v = m; for (int i = 0; i < n; i++) v = a[i & 15]; return v; }
int before_last(int *a, int n, int m) { int p = m, v = 0; for (int i = 0; i < n; i++) { p = v; v = a[i & 15]; } return p * 5 + v; }
int two_ways_out(int *a, int n, int m)
{
    int i, s = 0;
    for (i = m; i < n; i++) {
        s += a[i & 15];
        if (s > 40)
            break;
    }
    return s * 100 + i;
}
int nested(int *a, int n, int m)
{
    int s = 0, t = 0;
    for (int i = 0; i < n; i++) {
        for (int j = i + 1; j < m; j++) {
            t = a[(i + j) & 15];
            if (t == 7)
                continue;
            s += t;
        }
        a[i & 15] ^= s + t;
    }
    return s - t;
}
int pointers(int *a, int n, int m)
{
    int s = m;
    for (const int *p = a, *end = a + (n & 15); p < end; ++p)
        s += *p;
    for (const int *p = a + (n & 15); p-- > a;)
        s = s * 3 + *p;
    return s;
}
int length(int *a, int n, int m) { const int *p = a; a[n & 15] = 0; while (*p && p != a + 15) p++; return (int)(p - a) + m; }
void move_down(int *a, int n, int m) { n &= 15; for (int i = m & 7; i < n; i++) a[i] = a[i + 1]; }
void move_up(int *a, int n, int m) { memmove(a + (m & 3), a, (n & 7) * sizeof(int)); }
void clear(int *a, int n, int m) { for (int i = m & 3; i < (n & 15); i++) a[i] = 0; }
long long wide_counter(int *a, int n, int m) { int s = m; for (long long i = n; i > 0; i -= 2) s += a[i & 15]; return s; }
int choose(int *a, int n, int m)
{
    for (int i = 0; i < n; i++)
        switch (a[i & 15] & 7) {
        case 0: m += 3; break;
        case 1: m ^= 5;
        case 2: m -= i; break;
        case 3: return m;
        default: m++;
        }
    return m;
}
