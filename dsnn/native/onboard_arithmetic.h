/* Whole numbers: smaller and larger, rounding, saturation, and two 16-bit numbers at once on a Cortex-M4. */
#ifndef ONBOARD_ARITHMETIC_H
#define ONBOARD_ARITHMETIC_H

#include "onboard_target.h"

#if defined(__ARM_FEATURE_DSP)
#include <arm_acle.h>
#define BLOCK 1 /* cells that are computed together */
#else
#define BLOCK 64 /* as vector units like it */
#endif

#define LARGEST_G 32768

static int32_t larger(int32_t a, int32_t b) { return a > b ? a : b; }
static int32_t smaller(int32_t a, int32_t b) { return a < b ? a : b; }
static int within(int32_t value, int32_t low, int32_t high) { return value >= low && value <= high; }

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

/* ---- Pairs of 16-bit numbers in a word. ---- */

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

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion" /* within the macro __usat16 of arm_acle.h */
/* Both halves, 0 where negative. */
static int16x2_t positive_pair(int16x2_t pair) { return (int16x2_t)__usat16(pair, 15); }
#pragma GCC diagnostic pop
#endif

#endif
