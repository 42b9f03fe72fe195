/* A stage's instructions: the timer read at its end less the timer read at the end of the one before. */

#include <stdint.h>

#include "counter.h"

#define TIMER ((volatile uint32_t *)0x40000000u)
#define CONTROL 0u /* registers, in words */
#define VALUE 1u
#define RELOAD 2u
#define ENABLE 1u

uint32_t counter_ticks[COUNTER_STAGES], counter_calls[COUNTER_STAGES], counter_cost;
static uint32_t mark;

__attribute__((noinline)) void counter_begin(void) {
    mark = TIMER[VALUE];
}

__attribute__((noinline)) void counter_stage(unsigned stage) {
    const uint32_t now = TIMER[VALUE]; /* it counts down */
    if (stage < COUNTER_STAGES) {
        counter_ticks[stage] += mark - now;
        counter_calls[stage]++;
    }
    mark = TIMER[VALUE];
}

void counter_clear(void) {
    for (unsigned stage = 0; stage < COUNTER_STAGES; stage++) counter_ticks[stage] = counter_calls[stage] = 0;
}

void counter_start(void) {
    TIMER[RELOAD] = 0xFFFFFFFFu;
    TIMER[VALUE] = 0xFFFFFFFFu;
    TIMER[CONTROL] = ENABLE;
    counter_clear();
    counter_stage(0);
    counter_clear();
    counter_begin();
    counter_stage(0);
    counter_stage(1); /* nothing is between two calls: what a call costs. Four, as ticks are no whole instructions. */
    counter_stage(1);
    counter_stage(1);
    counter_stage(1);
    counter_cost = (counter_ticks[1] + 2u) / 4u;
    counter_clear();
}

uint32_t counter_known(void) {
    counter_clear();
    uint32_t rounds = COUNTER_KNOWN / 2u - 1u; /* with the two instructions before the loop: COUNTER_KNOWN in all */
    counter_begin();
    __asm__ volatile("nop\n\tnop\n1:\tsubs %0, %0, #1\n\tbne 1b" : "+r"(rounds) : : "cc");
    counter_stage(0);
    const uint32_t ticks = counter_ticks[0];
    counter_clear();
    return ticks;
}
