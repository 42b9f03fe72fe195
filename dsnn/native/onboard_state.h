/* The states of the network: what is kept from frame to frame, where it lies in the caller's memory, and which
 * configurations are legal. */
#ifndef ONBOARD_STATE_H
#define ONBOARD_STATE_H

#include "onboard_arithmetic.h"
#include "onboard_target.h"

#define LONGEST_SIDE 4096
#define ROOM ((size_t)8)

/* All states; the planes lie behind it. 48 bytes wherever it is compiled, so that a size holds for chip and host. */
struct onboard {
    union {
        config_of config;
        unsigned char *second; /* with ONBOARD_SPLIT, which knows its configuration: the other block of memory */
        int64_t room;
    } head;
    int64_t sums[2][2]; /* [HS, VS][ON, OFF]: low-passed field sums */
    int32_t newest;     /* plane of the last P */
    int32_t first;      /* no frame has been seen */
};

typedef struct {
    config_of c;
    size_t cells;
    uint8_t *luma;            /* of the last frame */
    int16_t *p;               /* n_p planes, at least one: P of the last frames, in a ring */
    uint8_t *la;              /* LA of ON and OFF with its residue, of the last frame; words if lamina_bits is 16 */
    int16_t *h[2];            /* F where positive, else LA - A */
    uint8_t *codes;           /* D: pathway by row by spacing by column; 16-bit words where state_bits says so */
    int16_t *blur_e, *blur_i; /* a row blurred along y, 8 d cells beyond either end */
    int32_t *la_row;          /* a row of signed LA */
    int16_t *f_row;           /* a row of F with a margin of the longest spacing at either end */
    int16_t *d_rows;          /* a row of D of each spacing */
    int16_t *no_row;          /* a row of zeros */
    uint8_t *moves;           /* rows: whether P is not 0 somewhere */
} planes;

static size_t taken(size_t *used, size_t count, size_t each)
{
    const size_t begin = *used;
    if (begin == SIZE_MAX || (count != 0 && each > (SIZE_MAX - begin - 2 * ROOM) / count)) {
        *used = SIZE_MAX;
        return 0;
    }
    *used = (begin + count * each + ROOM - 1) / ROOM * ROOM;
    return begin;
}

/* Where everything lies behind `base`, which may be NULL; the bytes from there on, SIZE_MAX if there cannot be as many.
 * With ONBOARD_SPLIT LA and h lie in `second`. */
static size_t lay_out(config_of c, unsigned char *base, unsigned char *second, planes *l)
{
    const size_t columns = (size_t)c->columns, cells = (size_t)c->rows * columns, radius = (size_t)(8 * c->d);
    const size_t margin = (size_t)(c->spacings * c->d), bytes = c->state_bits == 16 ? 2 : 1;
    size_t used = sizeof(onboard), at[11];
    at[0] = taken(&used, cells, 1);
    at[1] = taken(&used, cells * (size_t)larger(c->n_p, 1), 2);
#ifdef ONBOARD_SPLIT
    at[2] = 0;
    at[3] = ONBOARD_WHOLE(ONBOARD_LA_BYTES);
#else
    second = base;
    at[2] = taken(&used, cells * 2, c->lamina_bits == 16 ? 2 : 1);
    at[3] = taken(&used, cells * 2, 2);
#endif
    at[4] = taken(&used, cells, 2 * bytes * (size_t)c->spacings);
    at[5] = taken(&used, columns + 2 * radius, 2);
    at[6] = taken(&used, columns + 2 * radius, 2);
    at[7] = taken(&used, columns, 4);
    at[8] = taken(&used, columns + 2 * margin, 2);
    at[9] = taken(&used, columns * ((size_t)c->spacings + 1), 2);
    at[10] = taken(&used, (size_t)c->rows, 1);
    if (base != NULL) {
        l->c = c;
        l->cells = cells;
        l->luma = base + at[0];
        l->p = (int16_t *)(void *)(base + at[1]);
        l->la = second + at[2];
        l->h[0] = (int16_t *)(void *)(second + at[3]);
        l->h[1] = l->h[0] + cells;
        l->codes = base + at[4];
        l->blur_e = (int16_t *)(void *)(base + at[5]);
        l->blur_i = (int16_t *)(void *)(base + at[6]);
        l->la_row = (int32_t *)(void *)(base + at[7]);
        l->f_row = (int16_t *)(void *)(base + at[8]);
        l->no_row = (int16_t *)(void *)(base + at[9]);
        l->d_rows = l->no_row + columns;
        l->moves = base + at[10];
    }
    return used;
}

#ifdef ONBOARD_SPLIT
#define SECOND(model) ((model)->head.second)
#else
#define SECOND(model) NULL
#endif

static planes planes_of(onboard *m)
{
    planes l;
    lay_out(CONFIG(m), (unsigned char *)m, SECOND(m), &l);
    return l;
}

static int is_legal(config_of c)
{
    return within(c->rows, 2, LONGEST_SIDE) && within(c->columns, 2, LONGEST_SIDE) && within(c->n_p, 0, 60) &&
           within(c->d, 1, 16) && within(c->spacings, 0, 64) &&
           c->spacings * c->d < (c->rows > c->columns ? c->rows : c->columns) &&
           (c->state_bits == 8 || c->state_bits == 16) && (c->lamina_bits == 8 || c->lamina_bits == 16) &&
           within(c->p_frac, 0, 15) &&
           within(c->la_frac, 0, c->p_frac) && within(c->f_frac, 0, 15) && within(c->g_frac, 0, c->f_frac) &&
           within(c->work_frac, larger(c->f_frac, c->la_frac) + 1, 16) && within(c->f_max, 1, 32767) &&
           within(c->sigma_l, 0, 32440) && c->left_fast >= 0 && c->left_slow >= 0 && within(c->w_i, 0, 32768) &&
           within(c->field_shift, 0, 30) && within(c->alpha_mp, 0, 32768) && c->plate_limit >= 1 &&
           c->plate_limit <= (int64_t)1 << 46 && within(c->plate_shift, 0, 30) && c->plate_gain >= 0 &&
           within(c->plate_right, 0, 62) && within(c->thresholds_count, 0, 256);
}

#endif
