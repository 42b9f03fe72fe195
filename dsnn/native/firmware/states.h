/* The network's memory: one block, or with -DONBOARD_SPLIT two, in sections that the linker script places. */

#ifndef STATES_H
#define STATES_H

#include <stdint.h>

#ifdef ONBOARD_SPLIT
#include "split.h"

__attribute__((section(".bss.states"), aligned(8))) static uint8_t states[ONBOARD_FIRST_BYTES];
__attribute__((section(".bss.second"), aligned(8))) static uint8_t second[ONBOARD_SECOND_BYTES];

static onboard *states_make(void) {
    return onboard_make_split(states, sizeof states, second, sizeof second);
}
#else
__attribute__((section(".bss.states"), aligned(8))) static uint8_t states[ONBOARD_STATE_BYTES];

static onboard *states_make(void) {
    return onboard_make(states, sizeof states, 0);
}
#endif

#endif
