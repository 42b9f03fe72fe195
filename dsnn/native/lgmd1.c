/* The LGMD1 of Yue and Rind (2006): where its states lie, and its potential. The passes over its cells: passes.c. */
#include <string.h>

#include "lanes.h"
#include "models.h"

#define MAPS 5

static int is_legal(const lgmd1_config *c)
{
    return c->rows >= 2 && c->rows <= LONGEST_SIDE && c->columns >= 2 && c->columns <= LONGEST_SIDE;
}

/* Where everything lies. `base` is NULL where only the size is asked for. */
static size_t lay_out(const lgmd1_config *c, unsigned char *base)
{
    layout l = {0};
    const int32_t pitch = ROUND_UP(c->columns), width = pitch + 2 * MARGIN;
    const size_t map = product((size_t)c->rows + 2 * MARGIN, (size_t)width);
    size_t at[MAPS + 2], i;
    lgmd1 *m = (lgmd1 *)base;

    part(&l, 1, sizeof(lgmd1));
    at[0] = part(&l, (size_t)pitch, sizeof(float));
    at[1] = part(&l, (size_t)pitch, sizeof(float));
    for (i = 0; i < MAPS; i++)
        at[2 + i] = part(&l, map, sizeof(float));
    if (l.used > SIZE_MAX - ALIGNMENT)
        return 0;
    if (base == NULL)
        return l.used;
    m->config = *c;
    m->pitch = pitch;
    m->width = width;
    m->row = (float *)(base + at[0]);
    m->inside = (float *)(base + at[1]);
    m->luma = (float *)(base + at[2]);
    m->s = (float *)(base + at[3]);
    m->ce = (float *)(base + at[4]);
    m->now = (float *)(base + at[5]);
    m->before = (float *)(base + at[6]);
    m->states = at[0];
    m->states_size = l.used - at[0];
    return l.used;
}

size_t lgmd1_size(const lgmd1_config *config)
{
    const size_t size = is_legal(config) ? lay_out(config, NULL) : 0;
    return size == 0 ? 0 : size + ALIGNMENT;
}

lgmd1 *lgmd1_make(void *memory, size_t size, const lgmd1_config *config)
{
    const size_t needed = lgmd1_size(config);
    unsigned char *base;
    if (needed == 0 || memory == NULL || size < needed)
        return NULL;
    base = aligned(memory);
    lay_out(config, base);
    ((lgmd1 *)base)->passes = passes_for_this_processor();
    lgmd1_reset((lgmd1 *)base);
    return (lgmd1 *)base;
}

void lgmd1_reset(lgmd1 *m)
{
    int32_t x;
    memset((unsigned char *)m + m->states, 0, m->states_size);
    for (x = 0; x < m->config.columns; x++)
        m->inside[x] = 1.0f;
    m->first = 1;
    m->change = 0.0;
}

size_t lgmd1_state_size(const lgmd1 *m) { return sizeof m->change + 2 * sizeof(int32_t) + m->states_size; }

void lgmd1_save(const lgmd1 *m, uint8_t *state)
{
    const int32_t flags[2] = {m->first, m->now > m->before}; /* the two maps take turns */
    memcpy(state, &m->change, sizeof m->change);
    memcpy(state + sizeof m->change, flags, sizeof flags);
    memcpy(state + sizeof m->change + sizeof flags, (const unsigned char *)m + m->states, m->states_size);
}

int32_t lgmd1_load(lgmd1 *m, const uint8_t *state)
{
    float *const now = m->now;
    int32_t flags[2];
    memcpy(&m->change, state, sizeof m->change);
    memcpy(flags, state + sizeof m->change, sizeof flags);
    m->first = flags[0];
    if ((m->now > m->before) != (flags[1] != 0)) {
        m->now = m->before;
        m->before = now;
    }
    memcpy((unsigned char *)m + m->states, state + sizeof m->change + sizeof flags, m->states_size);
    return 1;
}

static void step(lgmd1 *m, const uint8_t *bytes, const float *floats, lgmd1_answer *answer)
{
    const lgmd1_config *c = &m->config;
    const double change = m->passes->excite(m, bytes, floats), scale = c->delta_c + (double)m->passes->group(m) / c->c_w;
    const double sum = m->passes->grouped(m, (float)(1.0 / scale));
    answer->potential = 1.0 / (1.0 + vision_exp(-sum / ((double)c->rows * c->columns)));
    answer->spike = answer->potential >= c->t_sp && m->change < c->t_ffi;
    m->change = change;
}

void lgmd1_step_u8(lgmd1 *m, const uint8_t *luma, lgmd1_answer *answer) { step(m, luma, NULL, answer); }
void lgmd1_step_f32(lgmd1 *m, const float *luma, lgmd1_answer *answer) { step(m, NULL, luma, answer); }
