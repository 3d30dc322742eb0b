/* The default network (4-3-1, 19 weights) in plain C: what a compiler makes of the same recurrence.
   Layout of the weights as in narx.structure: W1 (3 x 4) row by row, b1 (3), w2 (3), b2. */
#include <string.h>

enum { HIDDEN = 3, FEATURES = 4, WEIGHTS = 19, ROWS = 24, TILE = 64, LANES = 16 };

static inline double tanh_rational(double x)
{
    x = x > 18.0 ? 18.0 : x;
    x = x < -18.0 ? -18.0 : x;
    const double u = x * x, u2 = u * u, u4 = u2 * u2, u8 = u4 * u4;
    const double p =
        ((0.15095434005987102 * u + 0.9999999999999996)
         + (8.879124688954587e-05 * u + 0.005847359458277891) * u2)
        + ((1.9998666172009526e-09 * u + 6.134970316520188e-07)
           + (1.6389186309563738e-15 * u + 2.929283844358279e-12) * u2) * u4
        + 2.2603670673833237e-19 * u8;
    const double q =
        ((0.4842876733931986 * u + 1.0)
         + (0.0007997722924919918 * u + 0.033943250589355774) * u2)
        + ((3.851466712364893e-08 * u + 8.109131177774043e-06)
           + (7.948725204438082e-14 * u + 8.515639109259929e-11) * u2) * u4
        + (1.0113737118477227e-21 * u + 2.4133670618043534e-17) * u8;
    return x * p / q;
}

void rollout(const double *w, const double *v, long n, double *y)
{
    const double *b1 = w + 12, *w2 = w + 15;
    double v1 = 0, p1 = 0, p2 = 0;
    for (long k = 0; k < n; k++) {
        double p = w[18];
        for (int j = 0; j < HIDDEN; j++) {
            const double *r = w + FEATURES * j;
            p += w2[j] * tanh_rational(b1[j] + r[0] * v[k] + r[1] * v1 + r[3] * p2 + r[2] * p1);
        }
        v1 = v[k];
        p2 = p1;
        p1 = p;
        y[k] = p;
    }
}

/* Channels in tiles of LANES; v and y are (channel, time), as the project takes them. */
void rollout_many(const double *w, const double *v, long channels, long n, double *y)
{
    const double *b1 = w + 12, *w2 = w + 15;
    for (long c = 0; c < channels; c += LANES) {
        const int used = channels - c < LANES ? (int)(channels - c) : LANES;
        double v1[LANES] = {0}, p1[LANES] = {0}, p2[LANES] = {0};
        double in[TILE][LANES] = {{0}}, out[TILE][LANES];
        for (long start = 0; start < n; start += TILE) {
            const int m = n - start < TILE ? (int)(n - start) : TILE;
            for (int l = 0; l < used; l++)
                for (int t = 0; t < m; t++)
                    in[t][l] = v[(c + l) * n + start + t];
            for (int t = 0; t < m; t++)
                for (int l = 0; l < LANES; l++) {
                    double p = w[18];
                    for (int j = 0; j < HIDDEN; j++) {
                        const double *r = w + FEATURES * j;
                        p += w2[j] * tanh_rational(b1[j] + r[0] * in[t][l] + r[1] * v1[l]
                                                   + r[3] * p2[l] + r[2] * p1[l]);
                    }
                    v1[l] = in[t][l];
                    p2[l] = p1[l];
                    p1[l] = p;
                    out[t][l] = p;
                }
            for (int l = 0; l < used; l++)
                for (int t = 0; t < m; t++)
                    y[(c + l) * n + start + t] = out[t][l];
        }
    }
}

/* Forward sensitivities; products (ROWS x ROWS) of [J r]' [J r], row 19 the residuals'. */
void closed_loop_products(const double *w, const double *v, const double *target, long n,
                          double *products)
{
    const double *b1 = w + 12, *w2 = w + 15;
    static _Thread_local double s[TILE + 2][ROWS] __attribute__((aligned(64)));
    double v1 = 0, p1 = 0, p2 = 0;
    memset(s, 0, sizeof s);
    memset(products, 0, sizeof(double) * ROWS * ROWS);
    for (long start = 0; start < n; start += TILE) {
        const int m = n - start < TILE ? (int)(n - start) : TILE;
        for (int t = 0; t < m; t++) {
            const double x[FEATURES] = {v[start + t], v1, p1, p2};
            double *row = s[t + 2];
            double p = w[18], a1 = 0, a2 = 0, g[ROWS] = {0};
            for (int j = 0; j < HIDDEN; j++) {
                const double *r = w + FEATURES * j;
                const double h = tanh_rational(b1[j] + r[0] * x[0] + r[1] * x[1] + r[3] * x[3]
                                               + r[2] * x[2]);
                const double d = w2[j] * (1 - h * h);
                p += w2[j] * h;
                a1 += d * r[2];
                a2 += d * r[3];
                for (int f = 0; f < FEATURES; f++)
                    g[FEATURES * j + f] = d * x[f];
                g[12 + j] = d;
                g[15 + j] = h;
            }
            g[18] = 1;
            for (int i = 0; i < ROWS; i++)
                row[i] = g[i] + a1 * s[t + 1][i] + a2 * s[t][i];
            row[WEIGHTS] = p - target[start + t]; /* a row that no other looks back at */
            v1 = x[0];
            p2 = p1;
            p1 = p;
        }
        for (int i = 0; i < ROWS; i += 4) {
            double sum[4][ROWS] = {{0}};
            for (int t = 0; t < m; t++)
                for (int a = 0; a < 4; a++)
                    for (int b = 0; b < ROWS; b++)
                        sum[a][b] += s[t + 2][i + a] * s[t + 2][b];
            for (int a = 0; a < 4; a++)
                for (int b = 0; b < ROWS; b++)
                    products[(i + a) * ROWS + b] += sum[a][b];
        }
        memmove(s[0], s[m], 2 * sizeof s[0]);
    }
}
