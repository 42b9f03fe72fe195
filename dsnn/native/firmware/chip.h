/* What the chip's side is made of, whatever runs on it: memory marks of the linker script, the stack's high-water mark. */

#ifndef CHIP_H
#define CHIP_H

#include <stddef.h>
#include <stdint.h>

#define CHIP_FAULT 70 /* exit status of a processor fault */

extern uint32_t chip_stack_bottom[], chip_stack_top[];

/* Fill the stack below the caller's frame with a pattern. */
void chip_paint_stack(void);

/* The bytes of the stack that have been written since it was painted. Interrupts are counted if they came. */
uint32_t chip_stack_used(void);

/* End: under the emulator its process ends with this status. On a robot it stands still. */
void chip_exit(int status);

#endif
