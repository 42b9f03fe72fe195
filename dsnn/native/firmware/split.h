/* A model in two blocks of memory: LA and the adaptation's states lie apart from all else, so that neither of the
 * chip's two RAM regions has to have room for all. onboard.c is compiled with -DONBOARD_SPLIT then; the answers are the
 * same. */

#ifndef ONBOARD_SPLIT_H
#define ONBOARD_SPLIT_H

#include <stddef.h>

#define ONBOARD_SECOND_BYTES (8u * (ONBOARD_ROWS) * (ONBOARD_COLUMNS))
#define ONBOARD_FIRST_BYTES ((ONBOARD_STATE_BYTES) - ONBOARD_SECOND_BYTES)

/* As onboard_make; both blocks are aligned to 8 bytes. NULL where one is too small. */
struct onboard *onboard_make_split(void *first, size_t size, void *second, size_t second_size);

#endif
