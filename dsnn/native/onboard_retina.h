/* Retina: P (high-pass). The oldest plane of P is overwritten. */
#ifndef ONBOARD_RETINA_H
#define ONBOARD_RETINA_H

#include "onboard_arithmetic.h"
#include "onboard_state.h"
#include "onboard_target.h"

#define LARGEST_P 32767

static void retina_row(const planes *l, int32_t y, const uint8_t *luma, int first, int16_t *const of[])
{
    LOOP_CONFIG(l);
    int32_t x, i, k, any = 0;
    for (x = 0; x < c->columns; x += BLOCK) {
        const int32_t count = smaller(BLOCK, c->columns - x);
        const size_t at = (size_t)y * (size_t)c->columns + (size_t)x;
        int32_t left[BLOCK] = {0};
        for (i = 1; i <= c->n_p; i++)
            for (k = 0; k < count; k++)
                left[k] += c->residues[i - 1] * of[i][at + (size_t)k];
        for (k = 0; k < count; k++) {
            const int32_t now = luma[at + (size_t)k];
            int32_t change = first ? 0 : now - l->luma[at + (size_t)k], p;
            l->luma[at + (size_t)k] = (uint8_t)now;
            if (c->halved)
                change = 2 * larger(-127, smaller(127, change / 2));
            p = change * (INT32_C(1) << c->p_frac) + rounded(c, left[k], 15);
            p = larger(-LARGEST_P, signed_16_bits(p));
            of[0][at + (size_t)k] = (int16_t)p;
            any |= p;
        }
    }
    l->moves[y] = any != 0;
}

static void retina(onboard *m, const planes *l, const uint8_t *luma)
{
    const config_of c = CONFIG_OF(l);
    const int32_t count = larger(c->n_p, 1);
    int16_t *of[MOST_RESIDUES];
    int32_t i, y;
    m->newest = (m->newest + count - 1) % count;
    of[0] = l->p + (size_t)m->newest * l->cells;
    for (i = 1; i <= c->n_p; i++)
        of[i] = l->p + (size_t)((m->newest + i) % count) * l->cells;
    for (y = 0; y < c->rows; y++)
        retina_row(l, y, luma, m->first, of);
    m->first = 0;
}

#endif
