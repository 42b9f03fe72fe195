/* Parts of the memory that the caller gives, one behind the other. */
#ifndef MEMORY_H
#define MEMORY_H

#include <stddef.h>
#include <stdint.h>

#define ALIGNMENT ((size_t)64) /* a cache line: a part never shares one */
#define LONGEST_SIDE 65536

typedef struct {
    size_t used; /* bytes up to here; SIZE_MAX: more than there can be */
} layout;

/* Where `count` times `each` bytes begin. */
static inline size_t part(layout *l, size_t count, size_t each)
{
    const size_t begin = l->used;
    if (begin == SIZE_MAX || count > (SIZE_MAX - begin - ALIGNMENT) / each) {
        l->used = SIZE_MAX;
        return 0;
    }
    l->used = (begin + count * each + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    return begin;
}

static inline size_t product(size_t a, size_t b) { return b != 0 && a > SIZE_MAX / b ? SIZE_MAX : a * b; }

/* The first place in `memory` that suits a model: up to ALIGNMENT - 1 bytes further. */
static inline unsigned char *aligned(void *memory)
{
    const size_t over = (size_t)((uintptr_t)memory % ALIGNMENT);
    return (unsigned char *)memory + (over == 0 ? 0 : ALIGNMENT - over);
}

#endif
