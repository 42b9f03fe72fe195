/* The DSNN in whole numbers, for the processor of Colias (Cortex-M4) and, bit for bit the same, for any other.
 *
 * No floating point, no allocation, no global state, no library but memcpy and memset; no 64-bit division. The caller
 * gives the memory. dsnn/onboard/numpy_form.py is the specification, dsnn/onboard/fixed.py computes the constants.
 * A number in Qn has n fractional bits.
 *
 * On a host the constants are read from an onboard_config. With -DONBOARD_CONFIG_HEADER='"onboard_config.h"' (written
 * by dsnn/onboard/header.py) they are known to the compiler; onboard_config arguments are then not looked at and may
 * be NULL, and ONBOARD_STATE_BYTES is what onboard_size returns.
 *
 * ONBOARD_STAGE(i), where it is defined before onboard.c, is called at the end of stage i of ONBOARD_STAGE_NAMES: once
 * a frame for retina, correlation and plate, once a row for lamina and adaptation, which take turns row by row.
 *
 * Bounds: rows and columns of at most 4096, D and F below 2^15, so a field sum is below 2^60 with 64 spacings.
 */
#ifndef ONBOARD_H
#define ONBOARD_H

#include <stddef.h>
#include <stdint.h>

#define ONBOARD_STAGES 5
#define ONBOARD_STAGE_NAMES {"retina", "lamina", "adaptation", "correlation", "plate"}

typedef struct {
    int32_t rows, columns;    /* of the frames, 2..4096 each */
    int32_t n_p;              /* 0..60: earlier changes that are left in P */
    int32_t d;                /* 1..16: spacing of the detectors, px */
    int32_t spacings;         /* 0..64: d to spacings d, none of them longer than the image */
    int32_t on, off;          /* 0 blocks the pathway */
    int32_t dog, fdsr;        /* 0 leaves the difference of Gaussians, the adaptation out */
    int32_t halved;           /* not 0: the change of luminance without its lowest bit, within -127..127 */
    int32_t truncate;         /* not 0: magnitudes lose their lowest bits; 0: rounded to the nearest */
    int32_t state_bits;       /* of D: 8 or 16 */
    int32_t companding;       /* not 0: 8-bit D in segments */
    int32_t lamina_bits;      /* of LA: 8 or 16 */
    int32_t p_frac, la_frac;  /* fractional bits of P and LA, 0..15 */
    int32_t f_frac, g_frac;   /* of F, and of LA - A where that is negative */
    int32_t work_frac;        /* of LA - A before it is rounded: more than those three */
    int32_t f_max;            /* where F saturates, below 2^15 */
    int32_t sigma_l;          /* Q15: residue of the lamina */
    int32_t left_fast;        /* Q31: 1 - alpha(tau_fast) */
    int32_t left_slow;        /* Q31: 1 - alpha(tau_slow) */
    int32_t w_i;              /* Q15, up to 32768: weight of inhibition */
    int32_t field_shift;      /* bits that field sums lose, so that they stay below 2^45 */
    int32_t alpha_mp;         /* Q15, up to 32768: gain of the last low-pass */
    int64_t plate_limit;      /* field sum at which the sigmoid's table ends, up to 2^46 */
    int32_t plate_shift;      /* the sigmoid's argument in Q16 is (sum >> shift) * gain >> right */
    int32_t plate_gain;
    int32_t plate_right;
    int32_t thresholds_count; /* 0..256 */
    const int16_t *residues;  /* n_p, Q15: a_1 .. a_n_p */
    const int16_t *kernel_e;  /* 4 d + 1, Q15: one half of the Gaussian of width d, its centre first */
    const int16_t *kernel_i;  /* 8 d + 1, Q15: of width 2 d */
    const int32_t *alphas;    /* spacings, Q15, up to 32768: alpha(tau_s) */
    const uint16_t *decode;   /* 256: D of an 8-bit code */
    const uint8_t *decay;     /* spacings by 256: the code of an 8-bit D after a frame in which F is 0 */
    const int16_t *sigmoid;   /* 385, Q15: of 0, 1/32, ... 12 */
    const int16_t *thresholds; /* thresholds_count, Q15: |HS| from which on there are 1, 2, ... spikes */
} onboard_config;

typedef struct {
    int32_t hs, vs;               /* potentials, Q15, rightward and downward positive, within -32766..32766 */
    int32_t hs_spikes, vs_spikes; /* counts with the potential's sign */
} onboard_answer;

typedef struct onboard onboard;

/* Bytes that a model needs, at any alignment; 0 for a configuration that is not legal or too large for a size_t. */
size_t onboard_size(const onboard_config *config);

/* Make a model in `memory` of `size` bytes, at any alignment. The configuration and its tables are not copied and must
 * outlast the model. NULL where the configuration is not legal or the memory too small. */
onboard *onboard_make(void *memory, size_t size, const onboard_config *config);

/* Return to the state before the first frame. */
void onboard_reset(onboard *model);

/* Answer the next frame: rows x columns grey levels, row-major without gaps. */
void onboard_step(onboard *model, const uint8_t *luma, onboard_answer *answer);

/* The state between two frames, as dsnn_state_size, dsnn_save and dsnn_load of dsnn.h; not on the chip. */
size_t onboard_state_size(const onboard *model);
void onboard_save(const onboard *model, uint8_t *state);
int32_t onboard_load(onboard *model, const uint8_t *state);

/* Layers of the last frame, rows x columns each: P in Q p_frac, signed LA in Q la_frac, F of ON and OFF in Q f_frac. */
void onboard_maps(onboard *model, int32_t *p, int32_t *la, int32_t *f_on, int32_t *f_off);

#endif
