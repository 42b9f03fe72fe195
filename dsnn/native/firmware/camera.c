/* The camera's ring, and luma taken out of a YUV422 frame in place. */

#include <stdint.h>

#include "onboard_config.h"

#include "camera.h"

__attribute__((section(".bss.ring"))) uint32_t camera_ring[CAMERA_FRAMES][CAMERA_FRAME_WORDS];

const uint8_t *camera_luma(uint32_t *frame) {
    uint8_t *bytes = (uint8_t *)frame;
    const uint32_t whole = CAMERA_PIXELS / 4u;
    const uint32_t shift = 8u * CAMERA_LUMA;
    for (uint32_t i = 0; i < whole; i++) { /* little-endian: four pixels of two words into one */
        const uint32_t first = frame[2u * i] >> shift, second = frame[2u * i + 1u] >> shift;
        frame[i] = (first & 0xFFu) | (first >> 8 & 0xFF00u) | (second & 0xFFu) << 16 | (second << 8 & 0xFF000000u);
    }
    for (uint32_t i = 4u * whole; i < CAMERA_PIXELS; i++) bytes[i] = bytes[2u * i + CAMERA_LUMA];
    return bytes;
}

void camera_spread(uint32_t *frame) {
    uint8_t *bytes = (uint8_t *)frame;
    for (uint32_t i = CAMERA_PIXELS; i-- > 0;) {
        const uint8_t luma = bytes[i];
        bytes[2u * i + CAMERA_LUMA] = luma;
        bytes[2u * i + 1u - CAMERA_LUMA] = 128u;
    }
}
