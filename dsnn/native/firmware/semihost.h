/* Files of the computer that emulates or debugs the chip (Arm's "Semihosting for AArch32 and AArch64", release 2). */

#ifndef SEMIHOST_H
#define SEMIHOST_H

#include <stdint.h>

#define SEMIHOST_READ 1u  /* modes of fopen: "rb" */
#define SEMIHOST_WRITE 5u /* "wb" */

/* A handle, or a negative number. */
int32_t semihost_open(const char *path, uint32_t mode);

/* Read or write all `size` bytes. 1: done. 0: the file ended, or cannot be written. */
int semihost_read(int32_t handle, void *to, uint32_t size);
int semihost_write(int32_t handle, const void *from, uint32_t size);

#endif
