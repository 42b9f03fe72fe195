/* Semihosting calls, and the end of the emulator's process. */

#include <stdint.h>

#include "chip.h"
#include "semihost.h"

#define SYS_OPEN 0x01u
#define SYS_WRITE 0x05u
#define SYS_READ 0x06u
#define SYS_EXIT_EXTENDED 0x20u
#define APPLICATION_EXIT 0x20026u

static int32_t call(uint32_t operation, const uint32_t *block) {
    register uint32_t r0 __asm__("r0") = operation;
    register const uint32_t *r1 __asm__("r1") = block;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return (int32_t)r0;
}

int32_t semihost_open(const char *path, uint32_t mode) {
    uint32_t length = 0;
    while (path[length]) length++;
    const uint32_t block[3] = {(uint32_t)(uintptr_t)path, mode, length};
    return call(SYS_OPEN, block);
}

/* Both operations answer how many bytes are left to do; a pipe may give some of them first. */
static int transfer(uint32_t operation, int32_t handle, uint32_t place, uint32_t size) {
    while (size > 0) {
        const uint32_t block[3] = {(uint32_t)handle, place, size};
        const int32_t left = call(operation, block);
        if (left < 0 || (uint32_t)left >= size) return 0;
        place += size - (uint32_t)left;
        size = (uint32_t)left;
    }
    return 1;
}

int semihost_read(int32_t handle, void *to, uint32_t size) {
    return transfer(SYS_READ, handle, (uint32_t)(uintptr_t)to, size);
}

int semihost_write(int32_t handle, const void *from, uint32_t size) {
    return transfer(SYS_WRITE, handle, (uint32_t)(uintptr_t)from, size);
}

void chip_exit(int status) {
    const uint32_t block[2] = {APPLICATION_EXIT, (uint32_t)status};
    (void)call(SYS_EXIT_EXTENDED, block);
    for (;;) {
    }
}
