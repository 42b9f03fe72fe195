/* Lamina: signed LA of one row, ON positive, OFF negative. */
#ifndef ONBOARD_LAMINA_H
#define ONBOARD_LAMINA_H

#include "onboard_arithmetic.h"
#include "onboard_state.h"
#include "onboard_target.h"

/* A tap times up to BLOCK cells, and the same of two rows of cells added to the sums. */
static void weighed(int32_t *restrict sums, const int16_t *cells, int16_t tap, int32_t count)
{
    int32_t k;
    for (k = 0; k < count; k++)
        sums[k] = cells[k] * tap;
}

static void weigh(int32_t *restrict sums, const int16_t *a, const int16_t *b, int16_t tap, int32_t count)
{
    int32_t k;
    for (k = 0; k < count; k++)
        sums[k] += a[k] * tap + b[k] * tap;
}

#if defined(__ARM_FEATURE_DSP)
/* Cells x and x + 1 of a row, blurred along y. Where all rows are `inside` the image they follow one another from `top`
 * on, so that their addresses differ by constants. */
ALWAYS_INLINE void blur_pair(config_of c, const int16_t *const above[], const int16_t *const below[], const int16_t *top,
                             int inside, int16_t *e, int16_t *in, int32_t x)
{
    const int32_t columns = c->columns, radius_e = 4 * c->d, radius_i = 8 * c->d;
    const int16x2_t centre = pair_at(above[0] + x);
    const int32_t first = (int16_t)centre, second = centre >> 16;
    int32_t e0 = c->kernel_e[0] * first, e1 = c->kernel_e[0] * second, i;
    int32_t i0 = c->kernel_i[0] * first, i1 = c->kernel_i[0] * second;
    UNROLLED
    for (i = 1; i <= radius_i; i++) {
        const int16x2_t a = pair_at(inside ? top + (radius_i - i) * columns + x : above[i] + x);
        const int16x2_t b = pair_at(inside ? top + (radius_i + i) * columns + x : below[i] + x);
        const int16x2_t low = lower_halves(a, b), high = upper_halves(a, b);
        i0 = __smlad(low, c->kernel_i[i] * 65537, i0);
        i1 = __smlad(high, c->kernel_i[i] * 65537, i1);
        if (i <= radius_e) {
            e0 = __smlad(low, c->kernel_e[i] * 65537, e0);
            e1 = __smlad(high, c->kernel_e[i] * 65537, e1);
        }
    }
    e[x] = (int16_t)rounded(c, e0, 15);
    e[x + 1] = (int16_t)rounded(c, e1, 15);
    in[x] = (int16_t)rounded(c, i0, 15);
    in[x + 1] = (int16_t)rounded(c, i1, 15);
}
#endif

/* The row `y` of P, blurred along y by both Gaussians, with the ends repeated (two-gauss). */
static void blur_down(const planes *l, const int16_t *p, int32_t y)
{
    LOOP_CONFIG(l);
    const int32_t columns = c->columns, last = c->rows - 1, radius_e = 4 * c->d, radius_i = 8 * c->d;
    const int16_t *above[MOST_TAPS], *below[MOST_TAPS];
    int16_t *const e = l->blur_e + radius_i, *const in = l->blur_i + radius_i;
    int32_t x, i;
    for (i = 0; i <= radius_i; i++) {
        above[i] = p + (size_t)larger(y - i, 0) * (size_t)columns;
        below[i] = p + (size_t)smaller(y + i, last) * (size_t)columns;
    }
    x = 0;
#if defined(__ARM_FEATURE_DSP)
    if (y >= radius_i && y + radius_i <= last)
        for (; x < columns - 1; x += 2)
            blur_pair(c, above, below, above[radius_i], 1, e, in, x);
    else
        for (; x < columns - 1; x += 2)
            blur_pair(c, above, below, above[radius_i], 0, e, in, x);
#endif
    for (; x < columns; x += BLOCK) { /* tap by tap, as vector units like it */
        const int32_t count = smaller(BLOCK, columns - x);
        int32_t sum_e[BLOCK], sum_i[BLOCK], k;
        weighed(sum_e, above[0] + x, c->kernel_e[0], count);
        weighed(sum_i, above[0] + x, c->kernel_i[0], count);
        for (i = 1; i <= radius_e; i++)
            weigh(sum_e, above[i] + x, below[i] + x, c->kernel_e[i], count);
        for (i = 1; i <= radius_i; i++)
            weigh(sum_i, above[i] + x, below[i] + x, c->kernel_i[i], count);
        for (k = 0; k < count; k++) {
            e[x + k] = (int16_t)rounded(c, sum_e[k], 15);
            in[x + k] = (int16_t)rounded(c, sum_i[k], 15);
        }
    }
    for (i = 1; i <= radius_i; i++) {
        e[-i] = e[0];
        in[-i] = in[0];
        e[columns - 1 + i] = e[columns - 1];
        in[columns - 1 + i] = in[columns - 1];
    }
}

#if defined(__ARM_FEATURE_DSP)
/* The sum of a kernel's taps and the cells `radius` to either side, all of which are there. */
ALWAYS_INLINE int32_t blur_along(const int16_t *row, const int16_t *kernel, int32_t radius)
{
    int32_t sum = kernel[0] * row[0], i;
    UNROLLED
    for (i = 1; i < radius; i += 2) { /* two taps at once, on the left in the other order; a radius is even */
        const int32_t right = kernel[i] + kernel[i + 1] * 65536;
        sum = __smlad(pair_at(row + i), right, sum);
        sum = __smladx(pair_at(row - i - 1), right, sum);
    }
    return sum;
}
#endif

/* Signed LA of a cell from its P_e and P_i (polar-dogs); both of them, and `bits` more than LA, in the same format. */
ALWAYS_INLINE int32_t contrast(config_of c, int32_t e, int32_t in, int32_t bits)
{
    int32_t size;
    if ((e < 0) != (in < 0))
        return 0;
    size = rounded(c, e < in ? in - e : e - in, bits);
    return e < 0 ? -size : size;
}

#if defined(__ARM_FEATURE_DSP)
/* LA of a row from both of its blurs along y. */
NEVER_INLINE void lamina_along(const planes *l)
{
    const config_of c = CONFIG_OF(l);
    const int32_t columns = c->columns, radius_i = 8 * c->d, bits = c->p_frac - c->la_frac;
    int32_t *const la = l->la_row;
    int32_t x;
    for (x = 0; x < columns; x++) {
        const int32_t e = blur_along(l->blur_e + radius_i + x, c->kernel_e, 4 * c->d);
        la[x] = contrast(c, e, blur_along(l->blur_i + radius_i + x, c->kernel_i, radius_i), 15 + bits);
    }
}
#endif

/* Whether P of a row that the blur of row `y` reads is not 0 somewhere. */
static int moves_near(const planes *l, int32_t y)
{
    const int32_t radius = CONFIG_OF(l)->dog ? 8 * CONFIG_OF(l)->d : 0, end = smaller(y + radius, CONFIG_OF(l)->rows - 1);
    int32_t i;
    for (i = larger(y - radius, 0); i <= end; i++)
        if (l->moves[i])
            return 1;
    return 0;
}

static void lamina_row(const planes *l, const int16_t *p, int32_t y)
{
    LOOP_CONFIG(l);
    const int32_t columns = c->columns, radius_i = 8 * c->d, bits = c->p_frac - c->la_frac;
    int32_t *const la = l->la_row;
    int32_t x;
    if (!moves_near(l, y)) {
        memset(la, 0, (size_t)columns * sizeof *la);
        return;
    }
    if (!c->dog) {
        for (x = 0; x < columns; x++)
            la[x] = rounded(c, p[(size_t)y * (size_t)columns + (size_t)x], bits);
        return;
    }
    blur_down(l, p, y);
    x = 0;
#if defined(__ARM_FEATURE_DSP)
    lamina_along(l);
    x = columns;
#endif
    for (; x < columns; x += BLOCK) {
        const int32_t count = smaller(BLOCK, columns - x);
        const int16_t *const e = l->blur_e + radius_i + x, *const in = l->blur_i + radius_i + x;
        int32_t sum_e[BLOCK], sum_i[BLOCK], i;
        weighed(sum_e, e, c->kernel_e[0], count);
        weighed(sum_i, in, c->kernel_i[0], count);
        for (i = 1; i <= 4 * c->d; i++)
            weigh(sum_e, e - i, e + i, c->kernel_e[i], count);
        for (i = 1; i <= radius_i; i++)
            weigh(sum_i, in - i, in + i, c->kernel_i[i], count);
        for (i = 0; i < count; i++)
            la[x + i] = contrast(c, sum_e[i], sum_i[i], 15 + bits);
    }
}

#endif
