/* The network on this computer: raw frames come in, one byte a pixel; a line "hs vs hs_spikes vs_spikes" goes out. */

#include <stdint.h>
#include <stdio.h>

#include "onboard_config.h"

#include "onboard.h"

static union {
    uint64_t aligned;
    uint8_t bytes[ONBOARD_STATE_BYTES];
} states;
static uint8_t frame[(uint32_t)ONBOARD_ROWS * (uint32_t)ONBOARD_COLUMNS];

int main(void) {
    onboard *model = onboard_make(states.bytes, sizeof states.bytes, 0);
    if (!model) return 1;
    while (fread(frame, 1, sizeof frame, stdin) == sizeof frame) {
        onboard_answer seen;
        onboard_step(model, frame, &seen);
        printf("%ld %ld %ld %ld\n", (long)seen.hs, (long)seen.vs, (long)seen.hs_spikes, (long)seen.vs_spikes);
    }
    return 0;
}
