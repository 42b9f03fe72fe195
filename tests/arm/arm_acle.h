/* The instructions of the Cortex-M4 that onboard.c uses, in plain C: so that a host runs the code for the robot. */
#ifndef ARM_ACLE_H
#define ARM_ACLE_H

#include <stdint.h>

typedef int32_t int16x2_t;

static int16_t low_of(int16x2_t pair) { return (int16_t)(uint16_t)((uint32_t)pair & 0xffff); }
static int16_t high_of(int16x2_t pair) { return (int16_t)(uint16_t)((uint32_t)pair >> 16); }

/* Both products of halves, added. The processor wraps; here a sum that leaves 32 bits is an error of the caller's, which
 * a sanitizer shows. */
static inline int32_t __smlad(int16x2_t a, int16x2_t b, int32_t sum)
{
    return sum + (low_of(a) * low_of(b) + high_of(a) * high_of(b));
}

/* The same with the halves of `b` exchanged. */
static inline int32_t __smladx(int16x2_t a, int16x2_t b, int32_t sum)
{
    return sum + (low_of(a) * high_of(b) + high_of(a) * low_of(b));
}

static inline int64_t __smlald(int16x2_t a, int16x2_t b, int64_t sum)
{
    return sum + (int64_t)low_of(a) * low_of(b) + (int64_t)high_of(a) * high_of(b);
}

/* Each half, within 0 and what `bits` hold. */
static inline int32_t saturated(int32_t half, int bits)
{
    const int32_t most = (INT32_C(1) << bits) - 1;
    return half < 0 ? 0 : half > most ? most : half;
}

static inline int16x2_t __usat16(int16x2_t pair, int bits)
{
    return (int16x2_t)((uint32_t)saturated(low_of(pair), bits) | (uint32_t)saturated(high_of(pair), bits) << 16);
}

static inline uint32_t __usat(int32_t x, int bits) { return (uint32_t)saturated(x, bits); }

static inline int32_t __ssat(int32_t x, int bits)
{
    const int32_t most = (INT32_C(1) << (bits - 1)) - 1;
    return x > most ? most : x < -most - 1 ? -most - 1 : x;
}

#endif
