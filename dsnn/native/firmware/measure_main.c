/* The program that measures itself: it shows frames out of its own flash to the network, counts the cycles of each, and sends
 * potentials, spikes and cycles over the serial line, in records (record.h):
 *
 *     board, version of this list, board, columns, rows, trials, frames of a trial, us from frame to frame,
 *            clock in Hz, wait states of the flash, what counts cycles: dwt or none
 *     frame, trial, frame, hs, vs, hs_spikes, vs_spikes, cycles      potentials in Q15
 *     stack, bytes of it used
 *     end, frames sent
 *
 * '-' stands for what the board cannot tell. A frame's cycles are those of luma out of the camera's frame and of the network.
 * Nothing is sent and no interrupt comes while they are counted.
 */

#include <stdint.h>

#include "onboard_config.h"

#include "board.h"
#include "camera.h"
#include "chip.h"
#include "measure_frames.h"
#include "onboard.h"
#include "record.h"
#include "states.h"

#define VERSION 1u
enum { FAILED = 71 };

/* Cycles of the processor: the data watchpoint and trace unit (ARMv7-M architecture reference manual, C1.8). A processor
 * may come without it, and QEMU does: its registers read as 0 there. Differences hold up to 2^32 cycles, 23 s at 180 MHz. */
#define DEMCR (*(volatile uint32_t *)0xE000EDFCu)
#define DWT_CTRL (*(volatile uint32_t *)0xE0001000u)
#define DWT_CYCCNT (*(volatile uint32_t *)0xE0001004u)
#define TRCENA (1u << 24)
#define NOCYCCNT (1u << 25)
#define CYCCNTENA 1u

/* Start the counter. 1: it counts. 0: there is none. */
static int cycles_start(void) {
    DEMCR |= TRCENA;
    DWT_CYCCNT = 0;
    DWT_CTRL |= CYCCNTENA;
    if ((DWT_CTRL & (NOCYCCNT | CYCCNTENA)) != CYCCNTENA) return 0;
    const uint32_t before = DWT_CYCCNT;
    for (uint32_t i = 0; i < 16u; i++) __asm__ volatile("nop");
    return DWT_CYCCNT != before;
}

static int send(record *line) {
    const uint32_t length = record_end(line);
    board_send(line->text, length);
    return length != 0;
}

static void known(record *line, int32_t value) {
    if (value < 0)
        record_none(line);
    else
        record_signed(line, value);
}

static int send_board(int counts) {
    const uint32_t numbers[5] = {ONBOARD_COLUMNS, ONBOARD_ROWS, MEASURE_TRIALS, MEASURE_FRAMES, MEASURE_FRAME_US};
    record line;
    record_begin(&line, "board");
    record_unsigned(&line, VERSION);
    record_word(&line, board_name);
    for (uint32_t i = 0; i < 5u; i++) record_unsigned(&line, numbers[i]);
    known(&line, board_clock_hz());
    known(&line, board_flash_waits());
    record_word(&line, counts ? "dwt" : "none");
    return send(&line);
}

static int send_frame(uint32_t trial, uint32_t frame, const onboard_answer *seen, int counts, uint32_t cycles) {
    const int32_t numbers[4] = {seen->hs, seen->vs, seen->hs_spikes, seen->vs_spikes};
    record line;
    record_begin(&line, "frame");
    record_unsigned(&line, trial);
    record_unsigned(&line, frame);
    for (uint32_t i = 0; i < 4u; i++) record_signed(&line, numbers[i]);
    if (counts)
        record_unsigned(&line, cycles);
    else
        record_none(&line);
    return send(&line);
}

static int send_number(const char *kind, uint32_t number) {
    record line;
    record_begin(&line, kind);
    record_unsigned(&line, number);
    return send(&line);
}

/* A frame as the camera leaves it in its ring. */
static uint32_t *filled(uint32_t shown) {
    uint32_t *const ring = camera_ring[shown % CAMERA_FRAMES];
    uint8_t *const bytes = (uint8_t *)ring;
    for (uint32_t i = 0; i < CAMERA_PIXELS; i++) bytes[i] = measure_luma[shown][i];
    camera_spread(ring);
    return ring;
}

int main(void) {
    uint32_t shown = 0;
    board_start();
    onboard *const model = states_make();
    const int counts = cycles_start();
    int done = model && send_board(counts);
    for (uint32_t trial = 0; trial < MEASURE_TRIALS && done; trial++) {
        onboard_reset(model);
        for (uint32_t frame = 0; frame < MEASURE_FRAMES && done; frame++) {
            onboard_answer seen;
            uint32_t *const buffer = filled(shown++);
            const uint32_t before = DWT_CYCCNT;
            onboard_step(model, camera_luma(buffer), &seen);
            const uint32_t cycles = DWT_CYCCNT - before;
            done = send_frame(trial, frame, &seen, counts, cycles);
        }
    }
    return done && send_number("stack", chip_stack_used()) && send_number("end", shown) ? 0 : FAILED;
}
