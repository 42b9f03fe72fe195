/* The DSNN: retina, lamina, FDSR, correlators, lobula plate. Equation labels are those of the paper's source.
 *
 * One frame goes through three passes, each of which reads and writes its states once:
 *   retina      P of the whole frame, as the blur needs rows above and below;
 *   contrast    blur, lamina and FDSR of one row, which leave F of both pathways;
 *   correlate   every delayed state with F around it, summed over the field.
 */
#include "dsnn.h"

#include "lanes.h"
#include "memory.h"

#define LARGEST_D 16
#define LARGEST_N_P 60
#define LARGEST_N_CON 64
#define LARGEST_RADIUS (8 * LARGEST_D)

struct dsnn {
    dsnn_config config;    /* its tables lie in this memory */
    int32_t pitch;         /* columns, rounded up to whole lanes; what lies beyond `columns` stays 0 */
    int32_t margin_x, margin_y, width; /* F has a margin of zeros, as wide as the longest spacing; its row's length */
    int32_t spacings;      /* those that fit into the image: a pair that leaves it adds nothing */
    int32_t radius;        /* of the wider blur */
    int32_t newest;        /* which of the `changes` is that of the last frame */
    int32_t first;         /* whether no frame has come yet */
    double sums[2][2];     /* low-passed field sums: HS and VS, of ON and of OFF */
    float *luma;           /* rows x pitch: the last frame */
    float *changes;        /* (n_p + 1) x rows x pitch: P of the last frames, a ring */
    float *la[2];          /* rows x pitch: the lamina's signal, ON and OFF */
    float *adapted[2];     /* rows x pitch: LA less its adaptation, not rectified */
    float *f[2], *wf[2];   /* (rows + 2 margin_y) x width: F, and w_i F */
    float *delayed;        /* rows x 2 x spacings x pitch: sum of F with geometric weights; alpha times it is D_j */
    float *blur_e, *blur_i; /* radius + pitch + radius: one row, blurred down the columns */
    float *row;            /* pitch: a row of the frame as floats */
    float *inside;         /* pitch: 1 inside the image, 0 beyond */
    float *left;           /* spacings: 1 - alpha(tau_s) */
    size_t states;         /* where reset begins to clear, and how many bytes */
    size_t states_size;
};

static int32_t smaller(int32_t a, int32_t b) { return a < b ? a : b; }

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
    const int32_t margin_x = smaller(reach, c->columns), margin_y = smaller(reach, c->rows);
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
    size_t skipped;
    unsigned char *base;
    dsnn *m;
    int32_t j;
    if (needed == 0 || memory == NULL || size < needed)
        return NULL;
    base = aligned(memory, &skipped);
    lay_out(config, base);
    m = (dsnn *)base;
    for (j = 0; j < m->spacings; j++)
        m->left[j] = 1.0f - m->config.alphas[j];
    dsnn_reset(m);
    return m;
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
VISION_CLONES
static void retina_row(dsnn *m, int32_t y)
{
    const size_t at = (size_t)y * (size_t)m->pitch;
    const int32_t n_p = m->config.n_p, pitch = m->pitch, first = m->first;
    const float *row = m->row;
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
            p = add(p, mul(lanes_of(m->config.residues[i - 1]), load(earlier[i] + x)));
        store(now + x, flushed(p));
    }
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

/* The adaptation of one pathway's eight cells: fast on a rise, slow on a fall (fdsr-lowpass, fdsr-subtraction).
 * Kept as what is left of LA, g(t) = (1 - alpha) (g(t - 1) + LA(t) - LA(t - 1)), which is the same. */
VISION_INLINE lanes adapt(float *adapted, lanes la, lanes before, lanes left_fast, lanes left_slow)
{
    const lanes zero = lanes_of(0.0f), change = sub(la, before);
    const lanes left = add(where_ge(change, zero, left_fast), where_lt(change, zero, left_slow));
    const lanes g = flushed(mul(left, add(load(adapted), change)));
    store(adapted, g);
    return positive(g);
}

/* Lamina and FDSR of row `y`, which leave F and w_i F. */
VISION_INLINE void contrast_row_of(dsnn *m, int32_t y, int32_t radius_e, int32_t radius_i)
{
    const dsnn_config *c = &m->config;
    const lanes zero = lanes_of(0.0f), tiny = lanes_of(VISION_TINY), sigma_l = lanes_of(c->sigma_l);
    const lanes left_fast = lanes_of(c->left_fast), left_slow = lanes_of(c->left_slow), w_i = lanes_of(c->w_i);
    const size_t at = (size_t)y * (size_t)m->pitch;
    const int32_t pitch = m->pitch, fdsr = c->fdsr;
    const float *row_e = m->blur_e + radius_i, *row_i = m->blur_i + radius_i, *inside = m->inside;
    float *la[2], *adapted[2], *f[2], *wf[2];
    int32_t x, i;
    for (i = 0; i < 2; i++) {
        la[i] = m->la[i] + at;
        adapted[i] = m->adapted[i] + at;
        f[i] = field_row(m, m->f[i], y);
        wf[i] = field_row(m, m->wf[i], y);
    }
    blur_down(m, y, radius_e, radius_i);
    for (x = 0; x < pitch; x += LANES) {
        const lanes e = blur_along(row_e + x, c->kernel_e, radius_e), in = blur_along(row_i + x, c->kernel_i, radius_i);
        const lanes contrast = mul(magnitude(sub(e, in)), load(inside + x)); /* polar-dogs */
        const lanes split[2] = {where_ge(e, zero, where_ge(in, zero, contrast)),
                                where_lt(e, zero, where_lt(in, zero, contrast))};
        for (i = 0; i < 2; i++) {
            const lanes before = load(la[i] + x);
            const lanes sum = add(split[i], mul(sigma_l, before)), now = where_ge(sum, tiny, sum); /* halfwave */
            const lanes signal = fdsr ? adapt(adapted[i] + x, now, before, left_fast, left_slow) : now;
            const lanes weighted = mul(w_i, signal);
            store(la[i] + x, now);
            store(f[i] + x, signal);
            store(wf[i] + x, where_ge(weighted, tiny, weighted));
        }
    }
}

VISION_CLONES
static void contrast_row(dsnn *m, int32_t y)
{
    if (m->config.d == 1) /* the radii are constants there, and the loops unrolled */
        contrast_row_of(m, y, 4, 8);
    else
        contrast_row_of(m, y, 4 * m->config.d, 8 * m->config.d);
}

/* Delay F at every spacing s and sum D(x) (F(x + s) - w_i F(x - s)) over the field, along x and along y
 * (dynamic-lowpass, medulla-HS-EI to lobula-VS-EI). A sum is alpha times that of the states as they are stored. */
VISION_CLONES
static void correlate(dsnn *m, double fields[2][2])
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
                    const lanes sum = add(mul(left, load(state + x)), load(f + x)), now = where_ge(sum, tiny, sum);
                    store(state + x, now);
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

/* The potential of one system: HS or VS (LPTCs, HS-VS). */
static double lobula_plate(dsnn *m, int32_t system, const double fields[2])
{
    const int32_t intact[2] = {m->config.on, m->config.off};
    double potential = 0.0;
    int32_t i;
    for (i = 0; i < 2; i++) {
        double *sum = &m->sums[system][i];
        *sum += m->config.alpha_mp * (fields[i] - *sum);
        if (*sum < (double)VISION_TINY && *sum > -(double)VISION_TINY)
            *sum = 0.0;
        if (intact[i])
            potential += sigmoid(*sum, m->config.scale);
    }
    return potential;
}

static void begin_frame(dsnn *m) { m->newest = (m->newest + 1) % (m->config.n_p + 1); }

static void end_frame(dsnn *m, dsnn_answer *answer)
{
    double fields[2][2];
    int32_t y;
    for (y = 0; y < m->config.rows; y++)
        contrast_row(m, y);
    correlate(m, fields);
    m->first = 0;
    answer->hs = lobula_plate(m, 0, fields[0]);
    answer->vs = lobula_plate(m, 1, fields[1]);
    answer->hs_spikes = spikes(answer->hs, m->config.k_sp, m->config.t_sp);
    answer->vs_spikes = spikes(answer->vs, m->config.k_sp, m->config.t_sp);
}

void dsnn_step_u8(dsnn *m, const uint8_t *luma, dsnn_answer *answer)
{
    const int32_t columns = m->config.columns;
    int32_t x, y;
    begin_frame(m);
    for (y = 0; y < m->config.rows; y++, luma += columns) {
        for (x = 0; x < columns; x++)
            m->row[x] = (float)luma[x];
        retina_row(m, y);
    }
    end_frame(m, answer);
}

void dsnn_step_f32(dsnn *m, const float *luma, dsnn_answer *answer)
{
    int32_t y;
    begin_frame(m);
    for (y = 0; y < m->config.rows; y++, luma += m->config.columns) {
        memcpy(m->row, luma, (size_t)m->config.columns * sizeof(float));
        retina_row(m, y);
    }
    end_frame(m, answer);
}

void dsnn_maps(dsnn *m, float *p, float *la, float *f_on, float *f_off)
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
            const lanes e = blur_along(m->blur_e + radius + x, c->kernel_e, radius / 2);
            const lanes in = blur_along(m->blur_i + radius + x, c->kernel_i, radius), zero = lanes_of(0.0f);
            const lanes contrast = magnitude(sub(e, in));
            const lanes signed_contrast = sub(where_ge(e, zero, where_ge(in, zero, contrast)),
                                              where_lt(e, zero, where_lt(in, zero, contrast)));
            float lane[LANES];
            store(lane, signed_contrast);
            memcpy(la + at + (size_t)x, lane, (size_t)smaller(LANES, c->columns - x) * sizeof(float));
        }
    }
}

double dsnn_azimuth(const dsnn *m)
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
