/* The passes over the cells of the DSNN and the LGMD1. Equation labels are those of the DSNN's paper.
 *
 * A frame goes through three passes of the DSNN, each of which reads and writes its states once:
 *   retina      P of the whole frame, as the blur needs rows above and below;
 *   contrast    blur, lamina and FDSR, row by row, which leave F of both pathways;
 *   correlate   every delayed state with F around it, summed over the field.
 */
#include "models.h"

#include "lanes.h"

#ifndef VISION_PASSES
#define VISION_PASSES vision_passes_plain
#endif

/* Row `y` of a frame, given as bytes or else as floats, as floats. */
static void read_row(float *row, const uint8_t *bytes, const float *floats, int32_t y, int32_t columns)
{
    const size_t at = (size_t)y * (size_t)columns;
    int32_t x;
    if (bytes != NULL)
        for (x = 0; x < columns; x++)
            row[x] = (float)bytes[at + (size_t)x];
    else
        memcpy(row, floats + at, (size_t)columns * sizeof(float));
}

/* ---- The DSNN. ---- */

static size_t map_size(const dsnn *m) { return (size_t)m->config.rows * (size_t)m->pitch; }

static const float *change_before(const dsnn *m, int32_t frames)
{
    const int32_t count = m->config.n_p + 1;
    return m->changes + (size_t)((m->newest + count - frames) % count) * map_size(m);
}

/* Where F (or w_i F) at the left end of row `y` is. */
static float *field_row(const dsnn *m, float *field, int32_t y)
{
    return field + ((size_t)y + (size_t)m->margin_y) * (size_t)m->width + (size_t)m->margin_x;
}

/* P of one row of the frame, which stands in m->row (high-pass). */
VISION_INLINE void retina_row(dsnn *m, int32_t y)
{
    const size_t at = (size_t)y * (size_t)m->pitch;
    const int32_t n_p = m->config.n_p, pitch = m->pitch, first = m->first;
    const float *row = m->row, *residues = m->config.residues;
    const float *earlier[LARGEST_N_P + 1];
    float *luma = m->luma + at, *now = m->changes + (size_t)m->newest * map_size(m) + at;
    int32_t x, i;
    for (i = 1; i <= n_p; i++)
        earlier[i] = change_before(m, i) + at;
    for (x = 0; x < pitch; x += LANES) {
        const lanes seen = load(row + x);
        lanes p = first ? lanes_of(0.0f) : sub(seen, load(luma + x));
        store(luma + x, seen);
        for (i = 1; i <= n_p; i++)
            p = add(p, mul(lanes_of(residues[i - 1]), load(earlier[i] + x)));
        store(now + x, flushed(p));
    }
}

/* P of the whole frame, which is given as bytes or as floats. */
static void retina(dsnn *m, const uint8_t *bytes, const float *floats)
{
    const int32_t columns = m->config.columns, rows = m->config.rows;
    int32_t y;
    m->newest = (m->newest + 1) % (m->config.n_p + 1);
    for (y = 0; y < rows; y++) {
        read_row(m->row, bytes, floats, y, columns);
        retina_row(m, y);
    }
    m->first = 0;
}

/* Blur row `y` of P down the columns, into m->blur_e and m->blur_i, the border replicated (two-gauss). */
VISION_INLINE void blur_down(const dsnn *m, int32_t y, int32_t radius_e, int32_t radius_i)
{
    const float *p = change_before(m, 0), *kernel_e = m->config.kernel_e, *kernel_i = m->config.kernel_i;
    const float *above[LARGEST_RADIUS + 1], *below[LARGEST_RADIUS + 1];
    const int32_t pitch = m->pitch, columns = m->config.columns, last = m->config.rows - 1;
    float *out_e = m->blur_e + radius_i, *out_i = m->blur_i + radius_i;
    int32_t x, i;
    for (i = 0; i <= radius_i; i++) {
        above[i] = p + (size_t)(y < i ? 0 : y - i) * (size_t)pitch;
        below[i] = p + (size_t)(y + i > last ? last : y + i) * (size_t)pitch;
    }
    for (x = 0; x < pitch; x += LANES) {
        const lanes centre = load(above[0] + x);
        lanes e = mul(lanes_of(kernel_e[0]), centre), in = mul(lanes_of(kernel_i[0]), centre);
        for (i = 1; i <= radius_e; i++) {
            const lanes pair = add(load(above[i] + x), load(below[i] + x));
            e = add(e, mul(lanes_of(kernel_e[i]), pair));
            in = add(in, mul(lanes_of(kernel_i[i]), pair));
        }
        for (; i <= radius_i; i++)
            in = add(in, mul(lanes_of(kernel_i[i]), add(load(above[i] + x), load(below[i] + x))));
        store(out_e + x, e);
        store(out_i + x, in);
    }
    for (i = 1; i <= radius_i; i++) {
        out_e[-i] = out_e[0];
        out_i[-i] = out_i[0];
        out_e[columns - 1 + i] = out_e[columns - 1];
        out_i[columns - 1 + i] = out_i[columns - 1];
    }
}

/* The blur along the row of the eight cells from `row` on. */
VISION_INLINE lanes blur_along(const float *row, const float *kernel, int32_t radius)
{
    lanes sum = mul(lanes_of(kernel[0]), load(row));
    int32_t i;
    for (i = 1; i <= radius; i++)
        sum = add(sum, mul(lanes_of(kernel[i]), add(load(row - i), load(row + i))));
    return sum;
}

typedef struct {
    lanes on, off;
} pathways;

/* LA of the eight cells from column `x` of row `y` on, split by its sign (polar-dogs); the row is blurred already. */
VISION_INLINE pathways lamina(const dsnn *m, int32_t y, int32_t x, int32_t radius_e, int32_t radius_i)
{
    const lanes zero = lanes_of(0.0f);
    pathways split;
    if (!m->config.dog) {
        const lanes p = load(change_before(m, 0) + (size_t)y * (size_t)m->pitch + x);
        split.on = positive(p);
        split.off = where_lt(p, zero, sub(zero, p));
    } else {
        const lanes e = blur_along(m->blur_e + radius_i + x, m->config.kernel_e, radius_e);
        const lanes in = blur_along(m->blur_i + radius_i + x, m->config.kernel_i, radius_i);
        const lanes contrast = mul(magnitude(sub(e, in)), load(m->inside + x));
        const lanes sign = m->config.common ? in : e;
        split.on = where_ge(e, zero, where_ge(sign, zero, contrast));
        split.off = where_lt(e, zero, where_lt(sign, zero, contrast));
    }
    return split;
}

/* The adaptation of one pathway's eight cells: fast on a rise, slow on a fall (fdsr-lowpass, fdsr-subtraction).
 * Kept as what is left of LA, g(t) = (1 - alpha) (g(t - 1) + LA(t) - LA(t - 1)), which is the same.
 * With two taps nothing is kept, so that g(t - 1) stays 0. */
VISION_INLINE lanes adapt(float *adapted, lanes la, lanes before, lanes left_fast, lanes left_slow,
                          int32_t rectified, int32_t taps)
{
    const lanes zero = lanes_of(0.0f), change = sub(la, before);
    const lanes left = add(where_ge(change, zero, left_fast), where_lt(change, zero, left_slow));
    const lanes g = flushed(mul(left, add(load(adapted), change)));
    if (!taps)
        store(adapted, g);
    return rectified ? positive(g) : g;
}

/* Lamina and FDSR of row `y`, which leave F and w_i F. */
VISION_INLINE void contrast_row(dsnn *m, int32_t y, int32_t radius_e, int32_t radius_i)
{
    const dsnn_config *c = &m->config;
    const lanes tiny = lanes_of(VISION_TINY), sigma_l = lanes_of(c->sigma_l);
    const lanes left_fast = lanes_of(c->left_fast), left_slow = lanes_of(c->left_slow), w_i = lanes_of(c->w_i);
    const size_t at = (size_t)y * (size_t)m->pitch;
    const int32_t pitch = m->pitch, fdsr = c->fdsr, rectified = c->rectified, taps = c->taps_fdsr;
    float *la[2], *adapted[2], *f[2], *wf[2];
    int32_t x, i;
    for (i = 0; i < 2; i++) {
        la[i] = m->la[i] + at;
        adapted[i] = m->adapted[i] + at;
        f[i] = field_row(m, m->f[i], y);
        wf[i] = field_row(m, m->wf[i], y);
    }
    if (c->dog)
        blur_down(m, y, radius_e, radius_i);
    for (x = 0; x < pitch; x += LANES) {
        const pathways split = lamina(m, y, x, radius_e, radius_i);
        for (i = 0; i < 2; i++) {
            const lanes before = load(la[i] + x);
            const lanes sum = add(i == 0 ? split.on : split.off, mul(sigma_l, before)); /* halfwave */
            const lanes now = where_ge(sum, tiny, sum);
            const lanes signal =
                fdsr ? adapt(adapted[i] + x, now, before, left_fast, left_slow, rectified, taps) : now;
            store(la[i] + x, now);
            store(f[i] + x, signal);
            store(wf[i] + x, flushed(mul(w_i, signal)));
        }
    }
}

static void contrast(dsnn *m)
{
    const int32_t rows = m->config.rows, d = m->config.d;
    int32_t y;
    if (d == 1) /* the radii are constants there, and the loops unrolled */
        for (y = 0; y < rows; y++)
            contrast_row(m, y, 4, 8);
    else
        for (y = 0; y < rows; y++)
            contrast_row(m, y, 4 * d, 8 * d);
}

/* Delay F at every spacing s and sum D(x) (F(x + s) - w_i F(x - s)) over the field, along x and along y
 * (dynamic-lowpass, medulla-HS-EI to lobula-VS-EI). A sum is alpha times that of the states as they are stored.
 * With two taps D is alpha times the sum of F and its last value, which alone is stored. */
VISION_INLINE void correlate_field(dsnn *m, double fields[2][2], int32_t rectified, int32_t taps)
{
    const lanes tiny = lanes_of(VISION_TINY);
    const int32_t pitch = m->pitch, d = m->config.d, rows = m->config.rows, spacings = m->spacings;
    lanes hs[2], vs[2];
    float *state = m->delayed;
    int32_t y, i, j, x;
    for (i = 0; i < 2; i++)
        hs[i] = vs[i] = lanes_of(0.0f);
    for (y = 0; y < rows; y++)
        for (i = 0; i < 2; i++) {
            const float *f = field_row(m, m->f[i], y), *wf = field_row(m, m->wf[i], y);
            lanes row_hs = lanes_of(0.0f), row_vs = lanes_of(0.0f);
            for (j = 0; j < spacings; j++, state += pitch) {
                const ptrdiff_t along = smaller((j + 1) * d, m->margin_x);
                const ptrdiff_t down = (ptrdiff_t)smaller((j + 1) * d, m->margin_y) * m->width;
                const lanes left = lanes_of(m->left[j]), alpha = lanes_of(m->config.alphas[j]);
                lanes sum_hs = lanes_of(0.0f), sum_vs = lanes_of(0.0f);
                for (x = 0; x < pitch; x += LANES) {
                    const lanes sum = add(mul(left, load(state + x)), load(f + x));
                    const lanes now = rectified ? where_ge(sum, tiny, sum) : flushed(sum);
                    store(state + x, taps ? load(f + x) : now);
                    sum_hs = add(sum_hs, mul(now, sub(load(f + x + along), load(wf + x - along))));
                    sum_vs = add(sum_vs, mul(now, sub(load(f + x + down), load(wf + x - down))));
                }
                row_hs = add(row_hs, mul(alpha, sum_hs));
                row_vs = add(row_vs, mul(alpha, sum_vs));
            }
            hs[i] = add(hs[i], row_hs);
            vs[i] = add(vs[i], row_vs);
        }
    for (i = 0; i < 2; i++) {
        fields[0][i] = sum_of(hs[i]);
        fields[1][i] = sum_of(vs[i]);
    }
}

static void correlate(dsnn *m, double fields[2][2])
{
    if (m->config.taps_delay)
        correlate_field(m, fields, 0, 1);
    else if (m->config.rectified) /* F has no sign there, and the inner loop one operation less */
        correlate_field(m, fields, 1, 0);
    else
        correlate_field(m, fields, 0, 0);
}

static void maps(dsnn *m, float *p, float *la, float *f_on, float *f_off)
{
    const dsnn_config *c = &m->config;
    const int32_t radius = m->radius;
    int32_t x, y;
    for (y = 0; y < c->rows; y++) {
        const size_t at = (size_t)y * (size_t)c->columns;
        const float *now = change_before(m, 0) + (size_t)y * (size_t)m->pitch;
        memcpy(p + at, now, (size_t)c->columns * sizeof(float));
        memcpy(f_on + at, field_row(m, m->f[0], y), (size_t)c->columns * sizeof(float));
        memcpy(f_off + at, field_row(m, m->f[1], y), (size_t)c->columns * sizeof(float));
        blur_down(m, y, radius / 2, radius);
        for (x = 0; x < c->columns; x += LANES) {
            const pathways split = lamina(m, y, x, radius / 2, radius);
            float lane[LANES];
            store(lane, sub(split.on, split.off));
            memcpy(la + at + (size_t)x, lane, (size_t)smaller(LANES, c->columns - x) * sizeof(float));
        }
    }
}

static double azimuth(const dsnn *m)
{
    const int32_t rows = m->config.rows, columns = m->config.columns;
    double energy = 0.0, moment = 0.0;
    int32_t x, y, i;
    for (x = 0; x < m->pitch; x += LANES) {
        lanes sum = lanes_of(0.0f);
        float lane[LANES];
        for (y = 0; y < rows; y++)
            for (i = 0; i < 2; i++) {
                const lanes f = load(field_row(m, m->f[i], y) + x);
                sum = add(sum, mul(f, f));
            }
        store(lane, sum);
        for (i = 0; i < LANES; i++) {
            energy += (double)lane[i];
            moment += (double)lane[i] * (2.0 * (x + i) / (columns - 1) - 1.0);
        }
    }
    return moment / (energy + DSNN_LEAST_ENERGY);
}

/* ---- The LGMD1. ---- */

static size_t row_at(const lgmd1 *m, int32_t y) { return ((size_t)y + MARGIN) * (size_t)m->width + MARGIN; }

/* P and the summed cells S of one row of the frame, which stands in m->row. The lanes' sums of |P| are returned. */
VISION_INLINE lanes excite_row(lgmd1 *m, int32_t y)
{
    const lanes w_i = lanes_of(m->config.w_i), side = lanes_of(m->config.w_side), corner = lanes_of(m->config.w_corner);
    const size_t at = row_at(m, y);
    const int32_t pitch = m->pitch, width = m->width, first = m->first;
    const float *row = m->row, *before = m->before + at;
    float *luma = m->luma + at, *now = m->now + at, *s = m->s + at;
    lanes changes = lanes_of(0.0f);
    int32_t x;
    for (x = 0; x < pitch; x += LANES) {
        const lanes seen = load(row + x), p = first ? lanes_of(0.0f) : sub(seen, load(luma + x));
        const float *up = before + x - width, *here = before + x, *down = before + x + width;
        const lanes sides = add(add(load(up), load(down)), add(load(here - 1), load(here + 1)));
        const lanes corners = add(add(load(up - 1), load(up + 1)), add(load(down - 1), load(down + 1)));
        const lanes inhibition = magnitude(add(mul(side, sides), mul(corner, corners)));
        store(luma + x, seen);
        store(now + x, p);
        store(s + x, positive(sub(magnitude(p), mul(w_i, inhibition))));
        changes = add(changes, magnitude(p));
    }
    return changes;
}

/* The mean of S around each cell, into m->ce; the largest of them is returned. */
static float group(lgmd1 *m)
{
    const lanes ninth = lanes_of(1.0f / 9.0f);
    const int32_t rows = m->config.rows, pitch = m->pitch, width = m->width;
    lanes largest = lanes_of(0.0f);
    float lane[LANES], most = 0.0f;
    int32_t x, y;
    for (y = 0; y < rows; y++) {
        const float *s = m->s + row_at(m, y);
        float *ce = m->ce + row_at(m, y);
        for (x = 0; x < pitch; x += LANES) {
            const float *here = s + x;
            lanes sum = lanes_of(0.0f);
            int32_t i;
            for (i = -1; i <= 1; i++)
                sum = add(sum, add(load(here + i), add(load(here + i - width), load(here + i + width))));
            sum = mul(mul(sum, ninth), load(m->inside + x));
            store(ce + x, sum);
            largest = larger(largest, sum);
        }
    }
    store(lane, largest);
    for (x = 0; x < LANES; x++)
        most = lane[x] > most ? lane[x] : most;
    return most;
}

/* The sum of the grouped excitation that reaches the threshold. */
static double grouped(const lgmd1 *m, float gain)
{
    const lanes by = lanes_of(gain), t_g = lanes_of(m->config.t_g);
    const int32_t rows = m->config.rows, pitch = m->pitch;
    lanes sum = lanes_of(0.0f);
    int32_t x, y;
    for (y = 0; y < rows; y++) {
        const float *s = m->s + row_at(m, y), *ce = m->ce + row_at(m, y);
        lanes of_row = lanes_of(0.0f);
        for (x = 0; x < pitch; x += LANES) {
            const lanes g = mul(mul(load(s + x), load(ce + x)), by);
            of_row = add(of_row, where_ge(g, t_g, g));
        }
        sum = add(sum, of_row);
    }
    return sum_of(sum);
}

/* P and S of the whole frame, of either type; the mean magnitude of P is returned. */
static double excite(lgmd1 *m, const uint8_t *bytes, const float *floats)
{
    const int32_t columns = m->config.columns, rows = m->config.rows;
    float *const last = m->now;
    lanes changes = lanes_of(0.0f);
    int32_t y;
    m->now = m->before;
    m->before = last;
    for (y = 0; y < rows; y++) {
        read_row(m->row, bytes, floats, y, columns);
        changes = add(changes, excite_row(m, y));
    }
    m->first = 0;
    return sum_of(changes) / ((double)rows * columns);
}

const vision_passes VISION_PASSES = {retina, contrast, correlate, maps, azimuth, excite, group, grouped};
