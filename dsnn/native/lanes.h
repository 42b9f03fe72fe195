/* Eight floats that are computed side by side: compiler vectors where there are some, plain arrays elsewhere.
 *
 * Both give the same bits, as every operation is an IEEE operation of one lane. VISION_PLAIN chooses the arrays.
 */
#ifndef LANES_H
#define LANES_H

#include <stdint.h>
#include <string.h>

#include "dsnn.h"

#define LANES 8
#define ROUND_UP(n) (((n) + (LANES - 1)) / LANES * LANES)

#if !defined(VISION_PLAIN) && defined(__GNUC__)
#define VISION_VECTORS 1
#else
#define VISION_VECTORS 0
#endif

#if defined(__GNUC__)
#define VISION_INLINE static inline __attribute__((always_inline))
#else
#define VISION_INLINE static inline
#endif

#if VISION_VECTORS

typedef float lanes __attribute__((vector_size(4 * LANES)));
typedef int32_t bits __attribute__((vector_size(4 * LANES)));

VISION_INLINE lanes lanes_of(float x) { return (lanes){x, x, x, x, x, x, x, x}; }
VISION_INLINE lanes add(lanes a, lanes b) { return a + b; }
VISION_INLINE lanes sub(lanes a, lanes b) { return a - b; }
VISION_INLINE lanes mul(lanes a, lanes b) { return a * b; }
/* x where a >= b, 0 elsewhere; x where a < b, 0 elsewhere. */
VISION_INLINE lanes where_ge(lanes a, lanes b, lanes x) { return (lanes)((bits)(a >= b) & (bits)x); }
VISION_INLINE lanes where_lt(lanes a, lanes b, lanes x) { return (lanes)((bits)(a < b) & (bits)x); }
VISION_INLINE lanes magnitude(lanes a)
{
    const int32_t m = INT32_MAX;
    return (lanes)((bits)a & (bits){m, m, m, m, m, m, m, m});
}

#else

typedef struct {
    float lane[LANES];
} lanes;

#define EACH_LANE(expression)           \
    do {                                \
        int i;                          \
        for (i = 0; i < LANES; i++)     \
            r.lane[i] = (expression);   \
        return r;                       \
    } while (0)

VISION_INLINE lanes lanes_of(float x) { lanes r; EACH_LANE(x); }
VISION_INLINE lanes add(lanes a, lanes b) { lanes r; EACH_LANE(a.lane[i] + b.lane[i]); }
VISION_INLINE lanes sub(lanes a, lanes b) { lanes r; EACH_LANE(a.lane[i] - b.lane[i]); }
VISION_INLINE lanes mul(lanes a, lanes b) { lanes r; EACH_LANE(a.lane[i] * b.lane[i]); }
VISION_INLINE lanes where_ge(lanes a, lanes b, lanes x) { lanes r; EACH_LANE(a.lane[i] >= b.lane[i] ? x.lane[i] : 0.0f); }
VISION_INLINE lanes where_lt(lanes a, lanes b, lanes x) { lanes r; EACH_LANE(a.lane[i] < b.lane[i] ? x.lane[i] : 0.0f); }
VISION_INLINE lanes magnitude(lanes a) { lanes r; EACH_LANE(a.lane[i] < 0.0f ? -a.lane[i] : a.lane[i] + 0.0f); }

#endif

VISION_INLINE lanes load(const float *p)
{
    lanes v;
    memcpy(&v, p, sizeof v);
    return v;
}
VISION_INLINE void store(float *p, lanes v) { memcpy(p, &v, sizeof v); }

/* The larger of a and b, lane by lane. Neither may be NaN. */
VISION_INLINE lanes larger(lanes a, lanes b) { return add(where_ge(a, b, a), where_lt(a, b, b)); }
/* a where it is not below zero, +0 elsewhere. */
VISION_INLINE lanes positive(lanes a) { return where_ge(a, lanes_of(0.0f), a); }
/* a, and 0 where its magnitude is below VISION_TINY. */
VISION_INLINE lanes flushed(lanes a) { return where_ge(magnitude(a), lanes_of(VISION_TINY), a); }

/* The sum of the lanes, the first lane first. */
VISION_INLINE double sum_of(lanes v)
{
    float lane[LANES];
    double sum = 0.0;
    int i;
    memcpy(lane, &v, sizeof v);
    for (i = 0; i < LANES; i++)
        sum += (double)lane[i];
    return sum;
}

#endif
