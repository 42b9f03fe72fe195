/* The DSNN in whole numbers: see onboard.h. Labels are those of the paper's equations. */
#include "onboard.h"

#if defined(__ARM_FEATURE_DSP)
#include <arm_acle.h>
#endif
#if __STDC_HOSTED__
#include <string.h>
#else /* a compiler for bare metal may come without the header */
void *memcpy(void *to, const void *from, size_t size);
void *memset(void *to, int value, size_t size);
#endif

#ifdef ONBOARD_CONFIG_HEADER
#define ONBOARD_WITH_TABLES
#include ONBOARD_CONFIG_HEADER
#define CONFIG(model) ((void)(model), &onboard_fixed)
#define CONFIG_OF(planes) ((void)(planes), &onboard_fixed) /* not read from memory, so that constants are folded */
#define GIVEN(config) ((void)(config), &onboard_fixed)
#ifdef ONBOARD_SPLIT
#include "split.h"
#endif
#define MOST_RESIDUES (ONBOARD_N_P + 1)
#define MOST_TAPS (8 * ONBOARD_D + 1)
#else
#define CONFIG(model) ((model)->head.config)
#define CONFIG_OF(planes) ((planes)->c)
#define COPIED
#define GIVEN(config) (config)
#define MOST_RESIDUES 61
#define MOST_TAPS (8 * 16 + 1)
#endif

#ifndef ONBOARD_STAGE
#define ONBOARD_STAGE(i) ((void)0)
#endif

#if defined(__GNUC__)
#define ALWAYS_INLINE static inline __attribute__((always_inline)) /* where a flag is to be known to the compiler */
#define NEVER_INLINE static __attribute__((noinline)) /* where a loop needs all registers */
#define UNROLLED _Pragma("GCC unroll 32")
#define PARTLY_UNROLLED _Pragma("GCC unroll 7")
#else
#define NEVER_INLINE static
#define UNROLLED
#define PARTLY_UNROLLED
#define ALWAYS_INLINE static inline
#endif

#define LONGEST_SIDE 4096
#define LARGEST_P 32767
#define LARGEST_G 32768
#define SIGMOID_ENTRIES 385
#define MANTISSA 5 /* bits of a companded code's place within its segment */
#define LOWEST 18  /* bits that D in Q (f_frac + 15) loses in the lowest segment */
#define BLOCK 64  /* cells that are blurred together */
#define CHUNK 128 /* cells whose products are summed in 32 bits */
#define ROOM ((size_t)8)

typedef const onboard_config *config_of;

/* `c`, for loops over cells. Where it is memory, it is a copy, which no byte that the loop writes can be part of. */
#ifdef COPIED
#define LOOP_CONFIG(planes) const onboard_config own = *(planes)->c, *const c = &own
#else
#define LOOP_CONFIG(planes) const config_of c = CONFIG_OF(planes)
#endif

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

static int32_t larger(int32_t a, int32_t b) { return a > b ? a : b; }
static int32_t smaller(int32_t a, int32_t b) { return a < b ? a : b; }

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

static int within(int32_t value, int32_t low, int32_t high) { return value >= low && value <= high; }

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

#if defined(__ARM_FEATURE_DSP)
/* Two neighbours, the first in the lower half. */
static int16x2_t pair_at(const int16_t *from)
{
    int16x2_t pair;
    __builtin_memcpy(&pair, from, sizeof pair); /* one load; memcpy itself is a call where -ffreestanding is set */
    return pair;
}

/* The lower halves of two words as a pair, the first in the lower half, and the upper halves. */
ALWAYS_INLINE int16x2_t lower_halves(int32_t first, int32_t second)
{
    int16x2_t pair;
#if defined(__arm__) /* one instruction, which compilers do not find */
    __asm__("pkhbt %0, %1, %2, lsl #16" : "=r"(pair) : "r"(first), "r"(second));
#else
    pair = (int16x2_t)(((uint32_t)first & 0xffff) | (uint32_t)second << 16);
#endif
    return pair;
}

ALWAYS_INLINE int16x2_t upper_halves(int32_t first, int32_t second)
{
    int16x2_t pair;
#if defined(__arm__)
    __asm__("pkhtb %0, %1, %2, asr #16" : "=r"(pair) : "r"(second), "r"(first));
#else
    pair = (int16x2_t)(((uint32_t)second & 0xffff0000) | (uint32_t)first >> 16);
#endif
    return pair;
}
#endif

/* ---- Rounding: of magnitudes, so that the sign decides nothing; of two equally near values the smaller in size. ---- */

static int32_t rounded(config_of c, int32_t x, int32_t bits)
{
    const int32_t bias = c->truncate || bits == 0 ? 0 : (INT32_C(1) << (bits - 1)) - 1;
#if defined(__ARM_FEATURE_DSP) /* the same without a branch, where >> of a negative number rounds down */
    if (!c->truncate && bits > 0)
        return (x + bias + (int32_t)((uint32_t)x >> 31)) >> bits;
#endif
    return x < 0 ? -((bias - x) >> bits) : (x + bias) >> bits;
}

static int64_t rounded_long(config_of c, int64_t x, int32_t bits)
{
    const int64_t bias = c->truncate || bits == 0 ? 0 : (INT64_C(1) << (bits - 1)) - 1;
    return x < 0 ? -((bias - x) >> bits) : (x + bias) >> bits;
}

/* A number that is not negative, within 8 or 16 bits; and a number within the 16 bits of a signed word. */
#if defined(__ARM_FEATURE_DSP)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion" /* within the macros of arm_acle.h */
static int32_t within_8_bits(int32_t x) { return (int32_t)__usat(x, 8); }
static int32_t within_16_bits(int32_t x) { return (int32_t)__usat(x, 16); }
static int32_t signed_16_bits(int32_t x) { return (int32_t)__ssat(x, 16); }
#pragma GCC diagnostic pop
#else
static int32_t within_8_bits(int32_t x) { return smaller(x, UINT8_MAX); }
static int32_t within_16_bits(int32_t x) { return smaller(x, UINT16_MAX); }
static int32_t signed_16_bits(int32_t x) { return larger(-LARGEST_G, smaller(x, LARGEST_G - 1)); }
#endif

/* ---- Retina: P (high-pass). The oldest plane of P is overwritten. ---- */

static void retina_row(const planes *l, int32_t y, const uint8_t *luma, int first, int16_t *const of[])
{
    LOOP_CONFIG(l);
    const size_t row = (size_t)y * (size_t)c->columns;
    uint8_t *const before = l->luma + row;
    int32_t x, i, any = 0;
    for (x = 0; x < c->columns; x++) {
        const int32_t now = luma[row + (size_t)x];
        int32_t change = first ? 0 : now - before[x], left = 0, p;
        before[x] = (uint8_t)now;
        if (c->halved)
            change = 2 * larger(-127, smaller(127, change / 2));
        for (i = 1; i <= c->n_p; i++)
            left += c->residues[i - 1] * of[i][row + (size_t)x];
        p = change * (INT32_C(1) << c->p_frac) + rounded(c, left, 15);
        p = larger(-LARGEST_P, signed_16_bits(p));
        of[0][row + (size_t)x] = (int16_t)p;
        any |= p;
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

/* ---- Lamina: signed LA of one row, ON positive, OFF negative. ---- */

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

/* ---- Adaptation: LA with its residue, and F of one row (halfwave, fdsr-lowpass, fdsr-subtraction). ---- */

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

/* ---- Correlation: D at every spacing, and the field sums (dynamic-lowpass, medulla-HS-EI .. lobula-VS-EI). ---- */

/* How many bits `value` has above LOWEST + MANTISSA + 1: the segment of its code. `value` is below 2^30. */
static uint32_t segment_of(uint32_t value)
{
#if defined(__GNUC__)
    return 8 - (uint32_t)__builtin_clz(value | UINT32_C(1) << (LOWEST + MANTISSA)); /* 31 - (LOWEST + MANTISSA) is 8 */
#else
    uint32_t segment = 0;
    while (value >> (LOWEST + MANTISSA + 1 + segment) != 0)
        segment++;
    return segment;
#endif
}

/* As `rounded`, of a number above 0. */
static uint32_t rounded_positive(config_of c, uint32_t x, uint32_t bits)
{
    return c->truncate ? x >> bits : (((x - 1) >> (bits - 1)) + 1) >> 1;
}

/* The next code of an 8-bit D that takes `f`, above 0. */
static uint32_t risen(config_of c, uint32_t code, int32_t f, int32_t alpha)
{
    const int32_t d = c->decode[code];
    const uint32_t value = (uint32_t)((d << 15) + alpha * (f - d)); /* above 0, as f and alpha are */
#if defined(__ARM_FEATURE_DSP)
    if (c->companding && !c->truncate && alpha > 0 && alpha < 32768) { /* the same in fewer instructions */
        /* One less than the value: at a power of two both segments have one code. 17 is LOWEST - 1. */
        const uint32_t less = (uint32_t)__smlad(lower_halves(f, d), alpha + (32768 - alpha) * 65536, -1);
        const uint32_t shift = 25 - (uint32_t)__builtin_clz(less | UINT32_C(1) << (LOWEST + MANTISSA));
        return ((less >> shift) + (shift << (MANTISSA + 1)) - (17u << (MANTISSA + 1)) + 1) >> 1;
    }
#endif
    if (c->companding) {
        const uint32_t segment = segment_of(value);
        return (segment << MANTISSA) + rounded_positive(c, value, LOWEST + segment);
    }
    return rounded_positive(c, value, LOWEST + 4);
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
                const uint8_t code = c->decay[256 * j + codes[j * columns + x]];
                codes[j * columns + x] = code;
                rows[j * columns + x] = (int16_t)c->decode[code];
                any |= code;
            }
        } else {
            UNROLLED
            for (j = 0; j < spacings; j++) {
                const uint32_t code = risen(c, codes[j * columns + x], input, c->alphas[j]);
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

#if defined(__ARM_FEATURE_DSP)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion" /* within the macro __usat16 of arm_acle.h */
/* Both halves, 0 where negative. */
static int16x2_t positive_pair(int16x2_t pair) { return (int16x2_t)__usat16(pair, 15); }
#pragma GCC diagnostic pop
#endif

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
    for (; x < columns; x += CHUNK) { /* bytes of F apart: their sums over a chunk stay below 2^31 */
        const int32_t end = smaller(x + CHUNK, columns);
        int32_t low_e = 0, low_i = 0, high_e = 0, high_i = 0, at;
        for (at = x; at < end; at++) {
            const int16_t to_one = (int16_t)(are_h ? larger(one[at], 0) : one[at]);
            const int16_t to_other = (int16_t)(are_h ? larger(other[at], 0) : other[at]);
            low_e += d[at] * (int16_t)(to_one & 255);
            low_i += d[at] * (int16_t)(to_other & 255);
            high_e += d[at] * (int16_t)(to_one >> 8);
            high_i += d[at] * (int16_t)(to_other >> 8);
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

/* ---- Lobula plate: HS and VS, and their spikes (LPTCs, sigmoid, HS-VS, spiking). ---- */

/* Of a field sum that is not negative, in Q15 up to 1/2: the table's entries, joined by lines. */
static int32_t sigmoid(config_of c, int64_t sum)
{
    int64_t at;
    int32_t low, high;
    if (sum >= c->plate_limit)
        return c->sigmoid[SIGMOID_ENTRIES - 1];
    at = ((sum >> c->plate_shift) * c->plate_gain) >> c->plate_right;
    if (at > (SIGMOID_ENTRIES - 1) * 2048 - 1)
        at = (SIGMOID_ENTRIES - 1) * 2048 - 1;
    low = c->sigmoid[at >> 11];
    high = c->sigmoid[(at >> 11) + 1];
    return low + (((high - low) * (int32_t)(at & 2047) + 1024) >> 11);
}

static int32_t plate(onboard *m, const planes *l, int32_t system, const field fields[2])
{
    const config_of c = CONFIG_OF(l);
    int32_t potential = 0, i;
    for (i = 0; i < 2; i++) {
        const int64_t e = fields[i].e[system] >> c->field_shift, in = fields[i].i[system] >> c->field_shift;
        const int64_t now = rounded_long(c, e * 32768 - c->w_i * in, 15), before = m->sums[system][i];
        const int64_t sum = rounded_long(c, before * 32768 + c->alpha_mp * (now - before), 15);
        m->sums[system][i] = sum;
        if (i == 0 ? c->on : c->off)
            potential += sum < 0 ? -sigmoid(c, -sum) : sigmoid(c, sum);
    }
    return potential;
}

static int32_t spikes(config_of c, int32_t potential)
{
    const int32_t size = potential < 0 ? -potential : potential;
    int32_t count = 0;
    while (count < c->thresholds_count && size >= c->thresholds[count])
        count++;
    return potential < 0 ? -count : count;
}

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
