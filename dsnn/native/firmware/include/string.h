/* What the network needs of a C library, where there is none: memory.c has it. */

#ifndef CHIP_STRING_H
#define CHIP_STRING_H

#include <stddef.h>

void *memset(void *to, int value, size_t size);
void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memmove(void *to, const void *from, size_t size);

#endif
