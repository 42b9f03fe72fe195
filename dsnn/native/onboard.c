/* The DSNN in whole numbers: see onboard.h. Labels are those of the paper's equations.
 *
 * The headers onboard_*.h have its parts, as static functions, and are included here alone: one translation unit has one
 * copy of the tables, and the compiler inlines across all stages.
 */
#include "onboard.h"

#include "onboard_target.h"
#include "onboard_arithmetic.h"
#include "onboard_state.h"
#include "onboard_retina.h"
#include "onboard_lamina.h"
#include "onboard_adaptation.h"
#include "onboard_correlation.h"
#include "onboard_plate.h"

size_t onboard_size(const onboard_config *config)
{
    const config_of c = GIVEN(config);
    const size_t used = is_legal(c) ? lay_out(c, NULL, NULL, NULL) : SIZE_MAX;
    return used == SIZE_MAX ? 0 : used + ROOM;
}

#ifdef ONBOARD_SPLIT
onboard *onboard_make_split(void *memory, size_t size, void *second, size_t second_size)
{
    onboard *const m = memory;
    if (memory == NULL || second == NULL || (uintptr_t)memory % ROOM != 0 || (uintptr_t)second % ROOM != 0 ||
        size < onboard_size(NULL) - ROOM || second_size < ONBOARD_SECOND_BYTES)
        return NULL;
    m->head.second = second;
    onboard_reset(m);
    return m;
}
#else
onboard *onboard_make(void *memory, size_t size, const onboard_config *config)
{
    const config_of c = GIVEN(config);
    const size_t needed = onboard_size(c);
    onboard *m;
    if (needed == 0 || memory == NULL || size < needed)
        return NULL;
    m = (onboard *)(void *)((unsigned char *)memory + (ROOM - (size_t)((uintptr_t)memory % ROOM)) % ROOM);
    m->head.config = c;
    onboard_reset(m);
    return m;
}
#endif

void onboard_reset(onboard *m)
{
    const config_of c = CONFIG(m);
    memset((unsigned char *)m + sizeof *m, 0, lay_out(c, NULL, NULL, NULL) - sizeof *m);
#ifdef ONBOARD_SPLIT
    memset(m->head.second, 0, ONBOARD_SECOND_BYTES);
#endif
    memset(m->sums, 0, sizeof m->sums);
    m->newest = 0;
    m->first = 1;
}

#ifndef ONBOARD_CONFIG_HEADER
/* All but the head, which points to the configuration. */
size_t onboard_state_size(const onboard *m) { return lay_out(CONFIG(m), NULL, NULL, NULL) - sizeof m->head; }

void onboard_save(const onboard *m, uint8_t *state) { memcpy(state, (const unsigned char *)m + sizeof m->head, onboard_state_size(m)); }

int32_t onboard_load(onboard *m, const uint8_t *state)
{
    int32_t newest;
    memcpy(&newest, state + sizeof m->sums, sizeof newest);
    if (newest < 0 || newest >= larger(CONFIG(m)->n_p, 1))
        return 0;
    memcpy((unsigned char *)m + sizeof m->head, state, onboard_state_size(m));
    return 1;
}
#endif

void onboard_step(onboard *m, const uint8_t *luma, onboard_answer *answer)
{
    const planes l = planes_of(m);
    const int16_t *p;
    field fields[2];
    int32_t y;
    retina(m, &l, luma);
    ONBOARD_STAGE(0);
    p = l.p + (size_t)m->newest * l.cells;
    for (y = 0; y < CONFIG_OF(&l)->rows; y++) {
        lamina_row(&l, p, y);
        ONBOARD_STAGE(1);
        adapt_row(&l, y);
        ONBOARD_STAGE(2);
    }
    correlate(&l, 0, &fields[0]);
    correlate(&l, 1, &fields[1]);
    ONBOARD_STAGE(3);
    answer->hs = plate(m, &l, 0, fields);
    answer->vs = plate(m, &l, 1, fields);
    answer->hs_spikes = spikes(l.c, answer->hs);
    answer->vs_spikes = spikes(l.c, answer->vs);
    ONBOARD_STAGE(4);
}

void onboard_maps(onboard *m, int32_t *p, int32_t *la, int32_t *f_on, int32_t *f_off)
{
    const planes l = planes_of(m);
    const int16_t *const newest = l.p + (size_t)m->newest * l.cells;
    const size_t columns = (size_t)CONFIG_OF(&l)->columns;
    size_t i;
    int32_t y;
    for (y = 0; y < CONFIG_OF(&l)->rows; y++) {
        lamina_row(&l, newest, y);
        memcpy(la + (size_t)y * columns, l.la_row, columns * sizeof *la);
    }
    for (i = 0; i < l.cells; i++) {
        p[i] = newest[i];
        f_on[i] = larger(l.h[0][i], 0);
        f_off[i] = larger(l.h[1][i], 0);
    }
}
