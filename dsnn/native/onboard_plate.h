/* Lobula plate: HS and VS, and their spikes (LPTCs, sigmoid, HS-VS, spiking). */
#ifndef ONBOARD_PLATE_H
#define ONBOARD_PLATE_H

#include "onboard_arithmetic.h"
#include "onboard_correlation.h"
#include "onboard_state.h"
#include "onboard_target.h"

#define SIGMOID_ENTRIES 385

/* Of a field sum that is not negative, in Q15 up to 1/2: the table's entries, joined by lines. */
static int32_t sigmoid(config_of c, int64_t sum)
{
    int64_t at;
    int32_t low, high;
    if (sum >= c->plate_limit)
        return c->sigmoid[SIGMOID_ENTRIES - 1];
    at = ((sum >> c->plate_shift) * c->plate_gain) >> c->plate_right;
    if (at > (SIGMOID_ENTRIES - 1) * 2048 - 1)
        at = (SIGMOID_ENTRIES - 1) * 2048 - 1;
    low = c->sigmoid[at >> 11];
    high = c->sigmoid[(at >> 11) + 1];
    return low + (((high - low) * (int32_t)(at & 2047) + 1024) >> 11);
}

static int32_t plate(onboard *m, const planes *l, int32_t system, const field fields[2])
{
    const config_of c = CONFIG_OF(l);
    int32_t potential = 0, i;
    for (i = 0; i < 2; i++) {
        const int64_t e = fields[i].e[system] >> c->field_shift, in = fields[i].i[system] >> c->field_shift;
        const int64_t now = rounded_long(c, e * 32768 - c->w_i * in, 15), before = m->sums[system][i];
        const int64_t sum = rounded_long(c, before * 32768 + c->alpha_mp * (now - before), 15);
        m->sums[system][i] = sum;
        if (i == 0 ? c->on : c->off)
            potential += sum < 0 ? -sigmoid(c, -sum) : sigmoid(c, sum);
    }
    return potential;
}

static int32_t spikes(config_of c, int32_t potential)
{
    const int32_t size = potential < 0 ? -potential : potential;
    int32_t count = 0;
    while (count < c->thresholds_count && size >= c->thresholds[count])
        count++;
    return potential < 0 ? -count : count;
}

#endif
