/* Correlation: D at every spacing, and the field sums (dynamic-lowpass, medulla-HS-EI .. lobula-VS-EI). */
#ifndef ONBOARD_CORRELATION_H
#define ONBOARD_CORRELATION_H

#include "onboard_arithmetic.h"
#include "onboard_state.h"
#include "onboard_target.h"

#define MANTISSA 5 /* bits of a companded code's place within its segment */
#define SEGMENTS 7
#define LOWEST 18 /* bits that D in Q (f_frac + 15) loses in the lowest segment */
#define CHUNK 128 /* cells whose products are summed in 32 bits */

/* The next code of an 8-bit D that takes `f`, above 0. */
static int32_t risen(config_of c, uint32_t code, int32_t f, int32_t alpha)
{
    const int32_t d = c->decode[code], up = !c->truncate; /* from above the middle on, where it is not truncated */
    int32_t value = (d << 15) + alpha * (f - d) - up, twice, segment;
#if defined(__ARM_FEATURE_DSP)
    if (c->companding && !c->truncate && alpha > 0 && alpha < 32768) { /* the same in fewer instructions */
        /* One less than the value: at a power of two both segments have one code. */
        const uint32_t less = (uint32_t)__smlad(lower_halves(f, d), alpha + (32768 - alpha) * 65536, -1);
        const uint32_t shift = 25 - (uint32_t)__builtin_clz(less | UINT32_C(1) << (LOWEST + MANTISSA));
        return (int32_t)(((less >> shift) + (shift << (MANTISSA + 1)) - ((LOWEST - 1) << (MANTISSA + 1)) + 1) >> 1);
    }
#endif
#if defined(__GNUC__)
    if (c->companding) { /* 31 - (LOWEST + MANTISSA) is 8 */
        segment = 8 - __builtin_clz((uint32_t)larger(value, 0) | UINT32_C(1) << (LOWEST + MANTISSA));
        return ((value >> (LOWEST - 1 + segment)) + (segment << (MANTISSA + 1)) + up) >> 1;
    }
#endif
    twice = value >>= c->companding ? LOWEST - 1 : LOWEST + 3; /* the code with one bit more */
    for (segment = 1; c->companding && segment < SEGMENTS; segment++) /* the right one has the lowest code */
        twice = smaller(twice, (value >> segment) + (segment << (MANTISSA + 1)));
    return (twice + up) >> 1;
}

/* Low-pass 8-bit D of all spacings in a row, and leave them decoded in d_rows; whether any of it is not 0. */
static int delay_bytes(const planes *l, uint8_t *codes, const int16_t *f)
{
    LOOP_CONFIG(l);
    const int32_t columns = c->columns, spacings = c->spacings;
    int16_t *const rows = l->d_rows;
    int32_t x, j, any = 0;
    for (x = 0; x < columns; x++) {
        const int32_t input = f[x]; /* codes may be anything to the compiler: f too */
        if (input == 0) {
            UNROLLED
            for (j = 0; j < spacings; j++) {
                const uint8_t *const decay = c->decay + 256 * j;
                const uint8_t code = decay[codes[j * columns + x]];
                codes[j * columns + x] = code;
                rows[j * columns + x] = (int16_t)c->decode[code];
                any |= code;
            }
        } else {
            UNROLLED
            for (j = 0; j < spacings; j++) {
                const int32_t code = risen(c, codes[j * columns + x], input, c->alphas[j]);
                codes[j * columns + x] = (uint8_t)code;
                rows[j * columns + x] = (int16_t)c->decode[code];
            }
            any = 1;
        }
    }
    return any != 0;
}

/* The same of 16-bit D, which need no decoding. */
static int delay_words(const planes *l, uint16_t *words, const int16_t *f)
{
    LOOP_CONFIG(l);
    const int32_t columns = c->columns, spacings = c->spacings;
    int32_t x, j, any = 0;
    for (x = 0; x < columns; x++) {
        UNROLLED
        for (j = 0; j < spacings; j++) {
            const int32_t before = words[j * columns + x];
            const int32_t d = rounded(c, (before << 15) + c->alphas[j] * (f[x] - before), 15);
            words[j * columns + x] = (uint16_t)d;
            l->d_rows[j * columns + x] = (int16_t)d;
            any |= d;
        }
    }
    return any != 0;
}

typedef struct {
    int64_t e[2], i[2]; /* excitation and inhibition of HS, VS */
} field;

/* The sums of D times either of two rows of F. Negative entries of rows of h count as 0; there are none in f_row. */
ALWAYS_INLINE void products(config_of c, const int16_t *d, const int16_t *one, const int16_t *other, int are_h, int64_t *e,
                            int64_t *i)
{
    const int32_t columns = c->columns;
    int64_t sum_e = 0, sum_i = 0;
    int32_t x = 0;
#if defined(__ARM_FEATURE_DSP)
    PARTLY_UNROLLED
    for (; x < columns - 1; x += 2) { /* two cells at once: the sums are exact, so their order is free */
        const int16x2_t pair = pair_at(d + x), to_one = pair_at(one + x), to_other = pair_at(other + x);
        sum_e = __smlald(pair, are_h ? positive_pair(to_one) : to_one, sum_e);
        sum_i = __smlald(pair, are_h ? positive_pair(to_other) : to_other, sum_i);
    }
#endif
    for (; x < columns; x += CHUNK) { /* bytes of D apart: their sums over a chunk stay below 2^31 */
        const int32_t end = smaller(x + CHUNK, columns);
        int32_t low_e = 0, low_i = 0, high_e = 0, high_i = 0, at;
        for (at = x; at < end; at++) {
            const int16_t to_one = (int16_t)(are_h ? larger(one[at], 0) : one[at]);
            const int16_t to_other = (int16_t)(are_h ? larger(other[at], 0) : other[at]);
            low_e += (int16_t)(d[at] & 255) * to_one;
            low_i += (int16_t)(d[at] & 255) * to_other;
            high_e += (int16_t)(d[at] >> 8) * to_one;
            high_i += (int16_t)(d[at] >> 8) * to_other;
        }
        sum_e += (int64_t)high_e * 256 + low_e;
        sum_i += (int64_t)high_i * 256 + low_i;
    }
    *e += sum_e;
    *i += sum_i;
}

/* What the delayed signals of row `y` give, of which row `h` and those around it have F. */
static void correlate_row(const planes *l, int32_t y, const int16_t *h, const int16_t *f, field *sums)
{
    const config_of c = CONFIG_OF(l);
    const size_t columns = (size_t)c->columns;
    int32_t j;
    for (j = 0; j < c->spacings; j++) {
        const int32_t s = (j + 1) * c->d;
        const int16_t *const d = l->d_rows + (size_t)j * columns;
        const int16_t *const below = y + s < c->rows ? h + (size_t)s * columns : l->no_row;
        const int16_t *const above = y >= s ? h - (size_t)s * columns : l->no_row;
        products(c, d, f + s, f - s, 0, &sums->e[0], &sums->i[0]);
        products(c, d, below, above, 1, &sums->e[1], &sums->i[1]);
    }
}

static void correlate(const planes *l, int32_t pathway, field *sums)
{
    const config_of c = CONFIG_OF(l);
    const int32_t columns = c->columns, rows = c->rows;
    int16_t *const f = l->f_row + c->spacings * c->d;
    int32_t x, y;
    memset(sums, 0, sizeof *sums);
    for (y = 0; y < rows; y++) {
        const int16_t *const h = l->h[pathway] + (size_t)y * (size_t)columns;
        const size_t at = ((size_t)pathway * (size_t)rows + (size_t)y) * (size_t)c->spacings * (size_t)columns;
        x = 0;
#if defined(__ARM_FEATURE_DSP)
        for (; x < columns - 1; x += 2) {
            const int16x2_t pair = positive_pair(pair_at(h + x));
            __builtin_memcpy(f + x, &pair, sizeof pair);
        }
#endif
        for (; x < columns; x++)
            f[x] = (int16_t)larger(h[x], 0);
        if (c->state_bits == 16 ? delay_words(l, (uint16_t *)(void *)l->codes + at, f) : delay_bytes(l, l->codes + at, f))
            correlate_row(l, y, h, f, sums);
    }
}

#endif
