/* The DSNN (Fu, Bellotto and Yue 2018, arXiv 1808.07692) and the LGMD1 (Yue and Rind 2006) in C99.
 *
 * The functions allocate nothing, keep no global state, call no library (memcpy and memset aside) and read no file.
 * The caller gives the memory of a model, as many bytes as *_size says, and may free it at any time.
 * Two models may run at the same time in two threads; one model may not.
 *
 * The same frames give the same bits on every machine whose float and double are IEEE 754: every sum has a fixed
 * order, no product is contracted into a sum, exponentials are computed here (vision_exp), and states below
 * VISION_TINY are set to zero, so that the processor's own treatment of subnormal numbers never matters.
 * Compile with contraction off and without fast-math (GCC and Clang: -ffp-contract=off).
 *
 * Images are row-major without gaps, rows x columns, grey levels 0..255.
 */
#ifndef DSNN_H
#define DSNN_H

#include <stddef.h>
#include <stdint.h>

/* A float state whose magnitude is below this, in grey levels, is set to zero. */
#define VISION_TINY 1e-18f

/* The energy at which the azimuth is halfway to its value without noise: see dsnn_azimuth. */
#define DSNN_LEAST_ENERGY 1.0

/* e to the power x: within 1.25 units in the last place of the true value for |x| <= 700; 0 below -708, infinity above
 * 709. The same bits everywhere. dsnn/exponential.py is its twin in Python. */
double vision_exp(double x);

/* ---- The DSNN. Names are those of the paper; the tables are computed by the caller. ---- */

typedef struct {
    int32_t rows, columns;   /* of the frames; at least 2 each */
    int32_t n_p;             /* 0..60: earlier changes that are left in P */
    int32_t d;               /* 1..16: spacing of the detectors, px */
    int32_t n_con;           /* 1..64: spacings, d to n_con d */
    int32_t on, off;         /* 0 blocks the pathway */
    int32_t dog;             /* 0 leaves the difference of Gaussians out: LA = P */
    int32_t fdsr;            /* 0 leaves the adaptation out */
    int32_t rectified;       /* 0 passes F on with its sign */
    int32_t common;          /* LA takes the sign that both Gaussians share, else is 0; 0: it takes the centre's */
    float w_i;               /* weight of inhibition */
    float sigma_l;           /* residue of the lamina */
    float left_fast;         /* 1 - alpha(tau_fast) */
    float left_slow;         /* 1 - alpha(tau_slow) */
    double alpha_mp;         /* alpha(tau_mp) */
    double scale;            /* of the sigmoid: rows columns k_sig */
    double k_sp, t_sp;       /* gain and threshold of the spikes */
    const float *residues;   /* n_p: a_1 .. a_n_p */
    const float *kernel_e;   /* 4 d + 1: one half of the Gaussian of width d, its centre first */
    const float *kernel_i;   /* 8 d + 1: one half of the Gaussian of width 2 d */
    const float *alphas;     /* n_con: alpha(tau_s) from the nearest pair to the farthest */
    int32_t taps_fdsr;       /* 1: the adaptation is alpha x(t) + (1 - alpha) x(t - 1) of its input; 0: recursive */
    int32_t taps_delay;      /* the same of the delays; alphas must be above 0 then */
} dsnn_config;

typedef struct {
    double hs, vs;               /* potentials, rightward and downward positive */
    int32_t hs_spikes, vs_spikes; /* counts with the potential's sign */
} dsnn_answer;

typedef struct dsnn dsnn;

/* Bytes that a model needs; 0 for a configuration that is not legal or too large for a size_t. */
size_t dsnn_size(const dsnn_config *config);

/* Make a model in `memory` of `size` bytes, at any alignment. The tables are copied.
 * NULL where the configuration is not legal or the memory too small. */
dsnn *dsnn_make(void *memory, size_t size, const dsnn_config *config);

/* Return to the state before the first frame. */
void dsnn_reset(dsnn *model);

/* Answer the next frame. */
void dsnn_step_u8(dsnn *model, const uint8_t *luma, dsnn_answer *answer);
void dsnn_step_f32(dsnn *model, const float *luma, dsnn_answer *answer);

/* Take F from `front` from now on, which must live as long and see each frame before: its configuration may differ in
 * n_con, alphas, alpha_mp, and what dsnn_read takes. Such a model has no maps. 0, and nothing done, if it has more spacings. */
int32_t dsnn_follow(dsnn *model, const dsnn *front);

/* Answer the last frame again, with on, off, scale, k_sp and t_sp of another configuration: they act on sums alone. */
void dsnn_read(const dsnn *model, const dsnn_config *other, dsnn_answer *answer);

/* The state between two frames: bytes of it; a copy; and the same into a model of the same configuration, which answers
 * the next frames as the other would. It is for the same build and byte order. The size is 0 for a model that follows
 * another; `load` returns 0, and does nothing, for such a model and for bytes that are no state. */
size_t dsnn_state_size(const dsnn *model);
void dsnn_save(const dsnn *model, uint8_t *state);
int32_t dsnn_load(dsnn *model, const uint8_t *state);

/* Copies of the layers of the last frame, rows x columns each: P, LA (signed), F of ON and of OFF. */
void dsnn_maps(dsnn *model, float *p, float *la, float *f_on, float *f_off);

/* The mean column of F squared of the last frame, from -1 at the left edge to 1; 0 where nothing moves. */
double dsnn_azimuth(const dsnn *model);

/* ---- The LGMD1. ---- */

typedef struct {
    int32_t rows, columns;        /* of the frames; at least 2 each */
    float w_i, w_side, w_corner;  /* weights of inhibition */
    float t_g;                    /* threshold of the grouped excitation */
    double c_w, delta_c;          /* the grouping's scale */
    double t_ffi, t_sp;           /* veto, grey levels; spike threshold on the potential */
} lgmd1_config;

typedef struct {
    double potential;  /* k, from 0.5 at rest up to 1 */
    int32_t spike;     /* 0 or 1 */
} lgmd1_answer;

typedef struct lgmd1 lgmd1;

/* As their namesakes of the DSNN. */
size_t lgmd1_size(const lgmd1_config *config);
lgmd1 *lgmd1_make(void *memory, size_t size, const lgmd1_config *config);
void lgmd1_reset(lgmd1 *model);
void lgmd1_step_u8(lgmd1 *model, const uint8_t *luma, lgmd1_answer *answer);
void lgmd1_step_f32(lgmd1 *model, const float *luma, lgmd1_answer *answer);
size_t lgmd1_state_size(const lgmd1 *model);
void lgmd1_save(const lgmd1 *model, uint8_t *state);
int32_t lgmd1_load(lgmd1 *model, const uint8_t *state);

#endif
