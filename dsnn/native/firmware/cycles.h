/* Cycles of the processor: CYCCNT of the data watchpoint and trace unit (ARMv7-M architecture reference manual, C1.8).
 *
 * A processor may come without it, and QEMU does: its registers read as 0 there. Then nothing is counted, and nobody may
 * say a number. */

#ifndef CYCLES_H
#define CYCLES_H

#include <stdint.h>

/* Start the counter. 1: it counts. 0: there is none. */
int cycles_start(void);

/* Cycles up to now; differences hold up to 2^32 cycles, 23 s at 180 MHz. */
uint32_t cycles_now(void);

#endif
