/* A model in two blocks of memory: LA and the adaptation's states lie apart from all else, so that neither of the
 * chip's two RAM regions has to have room for all. onboard.c is compiled with -DONBOARD_SPLIT then; the answers are the
 * same. */

#ifndef ONBOARD_SPLIT_H
#define ONBOARD_SPLIT_H

#include <stddef.h>

/* LA of ON and OFF, then h of both, in words; every part of a block is a multiple of 8 bytes. */
#define ONBOARD_LA_BYTES (2u * (ONBOARD_LAMINA_BITS / 8u) * (ONBOARD_ROWS) * (ONBOARD_COLUMNS))
#define ONBOARD_H_BYTES (4u * (ONBOARD_ROWS) * (ONBOARD_COLUMNS))
#define ONBOARD_WHOLE(bytes) (((bytes) + 7u) / 8u * 8u)
#define ONBOARD_SECOND_BYTES (ONBOARD_WHOLE(ONBOARD_LA_BYTES) + ONBOARD_WHOLE(ONBOARD_H_BYTES))
#define ONBOARD_FIRST_BYTES ((ONBOARD_STATE_BYTES) - ONBOARD_SECOND_BYTES)

/* As onboard_make; both blocks are aligned to 8 bytes. NULL where one is too small. */
struct onboard *onboard_make_split(void *first, size_t size, void *second, size_t second_size);

#endif
