/* memset, memcpy and the painted stack. A compiler calls the first two by itself; there is no C library here. */

#include <stddef.h>
#include <stdint.h>

#include "chip.h"

#define PAINT 0xA5A5A5A5u
#define MARGIN 64u /* bytes below the stack pointer that chip_paint_stack itself may use */

#if defined(__clang__) /* or their loops become calls of themselves; GCC has a flag for that */
#define OWN_LOOP __attribute__((no_builtin("memset", "memcpy", "memmove")))
#else
#define OWN_LOOP
#endif

void *memset(void *to, int value, size_t size);
void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memmove(void *to, const void *from, size_t size);

typedef uint32_t __attribute__((may_alias)) word;

static int aligned(const void *to, const void *from) {
    return (((uintptr_t)to | (uintptr_t)from) & 3u) == 0;
}

OWN_LOOP void *memset(void *to, int value, size_t size) {
    uint8_t *byte = to;
    if (aligned(to, to)) {
        const uint32_t pattern = (uint32_t)(uint8_t)value * 0x01010101u;
        word *place = to;
        for (; size >= 4; size -= 4) *place++ = pattern;
        byte = (uint8_t *)place;
    }
    while (size--) *byte++ = (uint8_t)value;
    return to;
}

OWN_LOOP void *memcpy(void *restrict to, const void *restrict from, size_t size) {
    uint8_t *byte = to;
    const uint8_t *source = from;
    if (aligned(to, from)) {
        word *place = to;
        const word *there = from;
        for (; size >= 4; size -= 4) *place++ = *there++;
        byte = (uint8_t *)place;
        source = (const uint8_t *)there;
    }
    while (size--) *byte++ = *source++;
    return to;
}

OWN_LOOP void *memmove(void *to, const void *from, size_t size) {
    uint8_t *byte = to;
    const uint8_t *source = from;
    if (byte <= source || byte >= source + size) return memcpy(to, from, size);
    while (size--) byte[size] = source[size];
    return to;
}

void chip_paint_stack(void) {
    uint32_t here;
    __asm__ volatile("mov %0, sp" : "=r"(here));
    for (uint32_t *place = chip_stack_bottom; (uint32_t)(uintptr_t)place + MARGIN < here; place++) {
        *(volatile uint32_t *)place = PAINT;
    }
}

uint32_t chip_stack_used(void) {
    const uint32_t *place = chip_stack_bottom;
    while (place < chip_stack_top && *(const volatile uint32_t *)place == PAINT) place++;
    return (uint32_t)((uintptr_t)chip_stack_top - (uintptr_t)place);
}
