/* What the network of onboard.c is compiled for: where its constants are, what the compiler is told, and the two
 * functions of the C library. */
#ifndef ONBOARD_TARGET_H
#define ONBOARD_TARGET_H

#include "onboard.h"

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

typedef const onboard_config *config_of;

/* `c`, for loops over cells. Where it is memory, it is a copy, which no byte that the loop writes can be part of. */
#ifdef COPIED
#define LOOP_CONFIG(planes) const onboard_config own = *(planes)->c, *const c = &own
#else
#define LOOP_CONFIG(planes) const config_of c = CONFIG_OF(planes)
#endif

#endif
