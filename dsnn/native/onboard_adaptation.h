/* Adaptation: LA with its residue, and F of one row (halfwave, fdsr-lowpass, fdsr-subtraction). */
#ifndef ONBOARD_ADAPTATION_H
#define ONBOARD_ADAPTATION_H

#include "onboard_arithmetic.h"
#include "onboard_state.h"
#include "onboard_target.h"

/* F, or LA - A where that is negative, from the last one and LA before and now. */
static int32_t adapted(config_of c, int32_t h, int32_t before, int32_t la)
{
    const int32_t g = h * (INT32_C(1) << (c->work_frac - (h >= 0 ? c->f_frac : c->g_frac)));
    const int32_t gap = g + (la - before) * (INT32_C(1) << (c->work_frac - c->la_frac));
    const int64_t left = (int64_t)gap * (la >= before ? c->left_fast : c->left_slow); /* below 2^62 in size */
    int32_t size;
    if (left >= 0) {
        size = (int32_t)rounded_long(c, left, 31 + c->work_frac - c->f_frac);
        return smaller(size, c->f_max);
    }
    size = (int32_t)rounded_long(c, -left, 31 + c->work_frac - c->g_frac);
    return signed_16_bits(-size); /* -LARGEST_G is the least number of 16 bits */
}

/* LA as F, where there is no adaptation. */
static int32_t unadapted(config_of c, int32_t la)
{
    const int32_t bits = c->la_frac - c->f_frac;
    const int32_t f = bits > 0 ? rounded(c, la, bits) : la * (INT32_C(1) << (bits > 0 ? 0 : -bits));
    return smaller(f, c->f_max);
}

/* One pathway of a row, of sign 1 or -1, whose LA begins at entry `at`. */
ALWAYS_INLINE void adapt_cells(config_of c, const int32_t *la_row, int32_t sign, uint8_t *las, size_t at, int16_t *hs)
{
    const int wide = c->lamina_bits == 16;
    uint8_t *const bytes = las + at;
    uint16_t *const words = (uint16_t *)(void *)las + at;
    int32_t x;
    for (x = 0; x < c->columns; x++) {
        const int32_t before = wide ? words[x] : bytes[x], h = hs[x];
        int32_t la = larger(sign * la_row[x], 0);
        if ((la | before | h) == 0)
            continue;
        la += rounded(c, c->sigma_l * before, 15);
        la = wide ? within_16_bits(la) : within_8_bits(la);
        if (wide)
            words[x] = (uint16_t)la;
        else
            bytes[x] = (uint8_t)la;
        hs[x] = (int16_t)(c->fdsr ? adapted(c, h, before, la) : unadapted(c, la));
    }
}

NEVER_INLINE void adapt_row(const planes *l, int32_t y)
{
    LOOP_CONFIG(l);
    const size_t row = (size_t)y * (size_t)c->columns;
    adapt_cells(c, l->la_row, 1, l->la, row, l->h[0] + row);
    adapt_cells(c, l->la_row, -1, l->la, l->cells + row, l->h[1] + row);
}

#endif
