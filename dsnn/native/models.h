/* What the models hold, and the passes over their cells, which take nearly all of the time.
 *
 * passes.c is compiled once for every processor and, where CMakeLists.txt asks for it, once more for processors with
 * 256-bit registers. Both give the same bits. A model is told as it is made which it is to use.
 */
#ifndef MODELS_H
#define MODELS_H

#include "dsnn.h"
#include "memory.h"

#define LARGEST_D 16
#define LARGEST_N_P 60
#define LARGEST_N_CON 64
#define LARGEST_RADIUS (8 * LARGEST_D)
#define MARGIN 1 /* of the LGMD1's maps: zeros for the 3x3 neighbourhoods of the edge */

typedef struct {
    /* The DSNN: P of a frame, given as bytes or else as floats; F of both pathways; the field sums of HS and VS, of ON
     * and OFF each; the layers' copies. */
    void (*retina)(dsnn *m, const uint8_t *bytes, const float *floats);
    void (*contrast)(dsnn *m);
    void (*correlate)(dsnn *m, double fields[2][2]);
    void (*maps)(dsnn *m, float *p, float *la, float *f_on, float *f_off);
    double (*azimuth)(const dsnn *m);
    /* The LGMD1: P and S of a frame, with the mean of |P|; the groups' means, with the largest; the sum of what
     * reaches the threshold. */
    double (*excite)(lgmd1 *m, const uint8_t *bytes, const float *floats);
    float (*group)(lgmd1 *m);
    double (*grouped)(const lgmd1 *m, float gain);
} vision_passes;

extern const vision_passes vision_passes_plain, vision_passes_wide;

/* The passes for this processor. */
static inline const vision_passes *passes_for_this_processor(void)
{
#if defined(VISION_WIDE)
    if (__builtin_cpu_supports("avx2"))
        return &vision_passes_wide;
#endif
    return &vision_passes_plain;
}

struct dsnn {
    const vision_passes *passes;
    dsnn_config config;    /* its tables lie in this memory */
    int32_t pitch;         /* columns, rounded up to whole lanes; what lies beyond `columns` stays 0 */
    int32_t margin_x, margin_y, width; /* F has a margin of zeros, as wide as the longest spacing; its row's length */
    int32_t spacings;      /* those that fit into the image: a pair that leaves it adds nothing */
    int32_t radius;        /* of the wider blur */
    int32_t newest;        /* which of the `changes` is that of the last frame */
    int32_t first;         /* whether no frame has come yet */
    int32_t follows;       /* whether F is another model's */
    double sums[2][2];     /* low-passed field sums: HS and VS, of ON and of OFF */
    float *luma;           /* rows x pitch: the last frame */
    float *changes;        /* (n_p + 1) x rows x pitch: P of the last frames, a ring */
    float *la[2];          /* rows x pitch: the lamina's signal, ON and OFF */
    float *adapted[2];     /* rows x pitch: LA less its adaptation, not rectified */
    float *f[2], *wf[2];   /* (rows + 2 margin_y) x width: F, and w_i F */
    float *delayed;        /* rows x 2 x spacings x pitch: sum of F with geometric weights; alpha times it is D_j.
                              With two taps F of the last frame */
    float *blur_e, *blur_i; /* radius + pitch + radius: one row, blurred down the columns */
    float *row;            /* pitch: a row of the frame as floats */
    float *inside;         /* pitch: 1 inside the image, 0 beyond */
    float *left;           /* spacings: 1 - alpha(tau_s); with two taps over alpha */
    size_t states;         /* where reset begins to clear, and how many bytes */
    size_t states_size;
};

struct lgmd1 {
    const vision_passes *passes;
    lgmd1_config config;
    int32_t pitch, width;  /* columns rounded up to whole lanes; with the margins on both sides */
    int32_t first;         /* whether no frame has come yet */
    double change;         /* mean magnitude of P of the last frame, which vetoes */
    float *luma, *s, *ce;  /* rows x width, with margins: the last frame, summed cells, their groups' means */
    float *now, *before;   /* the same: P of this frame and of the last */
    float *row, *inside;   /* pitch: a row of the frame as floats; 1 inside the image, 0 beyond */
    size_t states, states_size;
};

static inline int32_t smaller(int32_t a, int32_t b) { return a < b ? a : b; }

#endif
