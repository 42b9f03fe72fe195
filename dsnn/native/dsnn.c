/* The DSNN: where its states lie, and the lobula plate. The passes over its cells are in passes.c. */
#include <string.h>

#include "lanes.h"
#include "models.h"

static int is_legal(const dsnn_config *c)
{
    return c->rows >= 2 && c->rows <= LONGEST_SIDE && c->columns >= 2 && c->columns <= LONGEST_SIDE && c->n_p >= 0 &&
           c->n_p <= LARGEST_N_P && c->d >= 1 && c->d <= LARGEST_D && c->n_con >= 1 && c->n_con <= LARGEST_N_CON;
}

/* Where everything lies. `base` is NULL where only the size is asked for. */
static size_t lay_out(const dsnn_config *c, unsigned char *base)
{
    layout l = {0};
    const int32_t sides = c->rows > c->columns ? c->rows : c->columns, pitch = ROUND_UP(c->columns);
    const int32_t spacings = smaller(c->n_con, (sides - 1) / c->d), reach = spacings * c->d;
    const int32_t margin_x = ROUND_UP(smaller(reach, c->columns)), margin_y = smaller(reach, c->rows);
    const int32_t width = pitch + 2 * margin_x, radius = 8 * c->d;
    const size_t map = product((size_t)c->rows, (size_t)pitch);
    const size_t field = product((size_t)c->rows + 2 * (size_t)margin_y, (size_t)width);
    size_t at[18], i;
    const size_t counts[18] = {
        (size_t)c->n_p, (size_t)(4 * c->d + 1), (size_t)(8 * c->d + 1), (size_t)c->n_con, (size_t)spacings + 1, /* 0..4 */
        (size_t)pitch, (size_t)pitch, (size_t)(pitch + 2 * radius), (size_t)(pitch + 2 * radius),               /* 5..8 */
        map, product(map, (size_t)c->n_p + 1), map, map, map, map,                                             /* 9..14 */
        product(field, 2), product(field, 2), product(product(map, 2), (size_t)spacings),                      /* 15..17 */
    };
    dsnn *m = (dsnn *)base;

    part(&l, 1, sizeof(dsnn));
    for (i = 0; i < 18; i++)
        at[i] = part(&l, counts[i], sizeof(float));
    if (l.used > SIZE_MAX - ALIGNMENT)
        return 0;
    if (base == NULL)
        return l.used;

    m->config = *c;
    m->config.residues = memcpy(base + at[0], c->residues, counts[0] * sizeof(float));
    m->config.kernel_e = memcpy(base + at[1], c->kernel_e, counts[1] * sizeof(float));
    m->config.kernel_i = memcpy(base + at[2], c->kernel_i, counts[2] * sizeof(float));
    m->config.alphas = memcpy(base + at[3], c->alphas, counts[3] * sizeof(float));
    m->left = (float *)(base + at[4]);
    m->row = (float *)(base + at[5]);
    m->inside = (float *)(base + at[6]);
    m->blur_e = (float *)(base + at[7]);
    m->blur_i = (float *)(base + at[8]);
    m->luma = (float *)(base + at[9]);
    m->changes = (float *)(base + at[10]);
    m->la[0] = (float *)(base + at[11]);
    m->la[1] = (float *)(base + at[12]);
    m->adapted[0] = (float *)(base + at[13]);
    m->adapted[1] = (float *)(base + at[14]);
    m->f[0] = (float *)(base + at[15]);
    m->f[1] = m->f[0] + field;
    m->wf[0] = (float *)(base + at[16]);
    m->wf[1] = m->wf[0] + field;
    m->delayed = (float *)(base + at[17]);
    m->pitch = pitch;
    m->margin_x = margin_x;
    m->margin_y = margin_y;
    m->width = width;
    m->spacings = spacings;
    m->radius = radius;
    m->states = at[5];
    m->states_size = l.used - at[5];
    return l.used;
}

size_t dsnn_size(const dsnn_config *config)
{
    const size_t size = is_legal(config) ? lay_out(config, NULL) : 0;
    return size == 0 ? 0 : size + ALIGNMENT;
}

dsnn *dsnn_make(void *memory, size_t size, const dsnn_config *config)
{
    const size_t needed = dsnn_size(config);
    unsigned char *base;
    dsnn *m;
    int32_t j;
    if (needed == 0 || memory == NULL || size < needed)
        return NULL;
    base = aligned(memory);
    lay_out(config, base);
    m = (dsnn *)base;
    m->passes = passes_for_this_processor();
    m->follows = 0;
    for (j = 0; j < m->spacings; j++)
        m->left[j] = (1.0f - m->config.alphas[j]) / (config->taps_delay ? m->config.alphas[j] : 1.0f);
    dsnn_reset(m);
    return m;
}

int32_t dsnn_follow(dsnn *m, const dsnn *front)
{
    int32_t i;
    if (m->spacings > front->spacings)
        return 0;
    for (i = 0; i < 2; i++) {
        m->f[i] = front->f[i];
        m->wf[i] = front->wf[i];
    }
    m->margin_x = front->margin_x;
    m->margin_y = front->margin_y;
    m->width = front->width;
    m->follows = 1;
    return 1;
}

void dsnn_reset(dsnn *m)
{
    int32_t x;
    memset((unsigned char *)m + m->states, 0, m->states_size);
    for (x = 0; x < m->config.columns; x++)
        m->inside[x] = 1.0f;
    m->sums[0][0] = m->sums[0][1] = m->sums[1][0] = m->sums[1][1] = 0.0;
    m->newest = 0;
    m->first = 1;
}

size_t dsnn_state_size(const dsnn *m) { return m->follows ? 0 : sizeof m->sums + 2 * sizeof(int32_t) + m->states_size; }

void dsnn_save(const dsnn *m, uint8_t *state)
{
    const int32_t counters[2] = {m->newest, m->first};
    memcpy(state, m->sums, sizeof m->sums);
    memcpy(state + sizeof m->sums, counters, sizeof counters);
    memcpy(state + sizeof m->sums + sizeof counters, (const unsigned char *)m + m->states, m->states_size);
}

int32_t dsnn_load(dsnn *m, const uint8_t *state)
{
    int32_t counters[2];
    memcpy(counters, state + sizeof m->sums, sizeof counters);
    if (m->follows || counters[0] < 0 || counters[0] > m->config.n_p)
        return 0;
    memcpy(m->sums, state, sizeof m->sums);
    m->newest = counters[0];
    m->first = counters[1];
    memcpy((unsigned char *)m + m->states, state + sizeof m->sums + sizeof counters, m->states_size);
    return 1;
}

/* An odd sigmoid into (-0.5, 0.5) (sigmoid). */
static double sigmoid(double x, double scale)
{
    const double size = x < 0.0 ? -x : x, y = 1.0 / (1.0 + vision_exp(-size / scale)) - 0.5;
    return x < 0.0 ? -y : y;
}

/* Spikes of one frame, with the potential's sign; none below the threshold, and none at rest (spiking). */
static int32_t spikes(double potential, double k_sp, double t_sp)
{
    const double size = potential < 0.0 ? -potential : potential;
    int32_t count;
    if (!(size >= t_sp) || potential == 0.0)
        return 0;
    count = (int32_t)vision_exp(k_sp * (size - t_sp));
    return potential < 0.0 ? -count : count;
}

/* The potential of one system, HS or VS: the sum of the intact pathways (HS-VS). */
static double potential(const double sums[2], const dsnn_config *c)
{
    double sum = 0.0;
    if (c->on)
        sum += sigmoid(sums[0], c->scale);
    if (c->off)
        sum += sigmoid(sums[1], c->scale);
    return sum;
}

void dsnn_read(const dsnn *m, const dsnn_config *c, dsnn_answer *answer)
{
    answer->hs = potential(m->sums[0], c);
    answer->vs = potential(m->sums[1], c);
    answer->hs_spikes = spikes(answer->hs, c->k_sp, c->t_sp);
    answer->vs_spikes = spikes(answer->vs, c->k_sp, c->t_sp);
}

static void step(dsnn *m, const uint8_t *bytes, const float *floats, dsnn_answer *answer)
{
    double fields[2][2];
    int32_t system, i;
    if (!m->follows) {
        m->passes->retina(m, bytes, floats);
        m->passes->contrast(m);
    }
    m->passes->correlate(m, fields);
    for (system = 0; system < 2; system++)
        for (i = 0; i < 2; i++) {
            double *sum = &m->sums[system][i];
            *sum += m->config.alpha_mp * (fields[system][i] - *sum); /* LPTCs */
            if (*sum < (double)VISION_TINY && *sum > -(double)VISION_TINY)
                *sum = 0.0;
        }
    dsnn_read(m, &m->config, answer);
}

void dsnn_step_u8(dsnn *m, const uint8_t *luma, dsnn_answer *answer) { step(m, luma, NULL, answer); }
void dsnn_step_f32(dsnn *m, const float *luma, dsnn_answer *answer) { step(m, NULL, luma, answer); }

void dsnn_maps(dsnn *m, float *p, float *la, float *f_on, float *f_off) { m->passes->maps(m, p, la, f_on, f_off); }

double dsnn_azimuth(const dsnn *m) { return m->passes->azimuth(m); }
