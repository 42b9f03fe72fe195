/* Instructions of each stage, counted under an emulator.
 *
 * The board mps2-an386 has a 32-bit timer that counts down at 25 MHz (Arm Cortex-M System Design Kit, APB timer). QEMU
 * with "-icount shift=S" gives every instruction 2^S ns: with S = 8 the timer moves 6.4 ticks an instruction, so that a
 * difference of its readings tells instructions one by one. On the robot this file has no place: there is no such
 * timer at that address.
 */

#ifndef COUNTER_H
#define COUNTER_H

#include <stdint.h>

#define COUNTER_STAGES 12 /* stages that fit: those of the network, and the camera's */

/* Start the timer, and measure what counting itself costs. */
void counter_start(void);

/* Ticks of the timer up to now and since `counter_begin` belong to a stage. */
void counter_begin(void);
void counter_stage(unsigned stage);

/* Timer ticks of each stage since `counter_clear`, its calls, and the cost of one call, in ticks. */
extern uint32_t counter_ticks[COUNTER_STAGES], counter_calls[COUNTER_STAGES], counter_cost;
void counter_clear(void);

/* Ticks of COUNTER_KNOWN instructions, counted as a stage is: whoever reads counts checks the counter by them. */
#define COUNTER_KNOWN 4096u
uint32_t counter_known(void);

#endif
