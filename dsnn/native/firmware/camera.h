/* The camera's side of memory: a ring of YUV422 frames, as a DMA controller fills it. */

#ifndef CAMERA_H
#define CAMERA_H

#include <stdint.h>

#ifndef CAMERA_LUMA
#define CAMERA_LUMA 0 /* 0: bytes come as Y U Y V; 1: as U Y V Y (a register of the OV7670 decides) */
#endif
#ifndef CAMERA_FRAMES
#define CAMERA_FRAMES 3 /* one that the camera writes, one in work, one ready */
#endif
#define CAMERA_PIXELS ((uint32_t)ONBOARD_ROWS * (uint32_t)ONBOARD_COLUMNS)
#define CAMERA_FRAME_BYTES (2u * CAMERA_PIXELS)
#define CAMERA_FRAME_WORDS ((CAMERA_FRAME_BYTES + 3u) / 4u)

extern uint32_t camera_ring[CAMERA_FRAMES][CAMERA_FRAME_WORDS];

/* Move a frame's luma to its front, one byte a pixel, and return it. The frame is overwritten: it needs no buffer
 * beside the ring, whose other frames the camera fills meanwhile. */
const uint8_t *camera_luma(uint32_t *frame);

/* For tests: spread luma at a frame's front over its YUV422 places, with grey chroma; undone by camera_luma. */
void camera_spread(uint32_t *frame);

#endif
