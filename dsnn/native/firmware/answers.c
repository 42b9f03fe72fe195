/* The test program: frames come in by semihosting, answers go out. Commands are words on the emulator's standard
 * input; every command has one answer on its standard output.
 *
 * HELLO    -> magic, rows, columns, stages, state bytes, ticks that one reading of the counter costs,
 *             ticks of COUNTER_KNOWN instructions
 * FRAME, rows x columns bytes of luma -> hs, vs, hs_spikes, vs_spikes; ticks of each stage; calls of each stage
 * RESET    -> magic
 * STACK    -> bytes of the stack used so far
 * END, or the end of the input: the program ends.
 */

#include <stdint.h>

#include "onboard_config.h"

#include "camera.h"
#include "chip.h"
#include "counter.h"
#include "onboard.h"
#include "semihost.h"
#include "states.h"

#define MAGIC 0x444F4231u
enum { END = 0, HELLO = 1, FRAME = 2, RESET = 3, STACK = 4 };
enum { FAILED = 71 };
#define INPUT_STAGE (COUNTER_STAGES - 1) /* luma out of the camera's frame */

static int32_t in, out;

static int answer(const void *words, uint32_t size) {
    return semihost_write(out, words, size);
}

static int frame(onboard *model, uint32_t *buffer) {
    if (!semihost_read(in, buffer, CAMERA_PIXELS)) return 0;
    camera_spread(buffer);
    onboard_answer made;
    counter_clear();
    counter_begin();
    const uint8_t *luma = camera_luma(buffer);
    counter_stage(INPUT_STAGE);
    onboard_step(model, luma, &made);
    const int32_t words[4] = {made.hs, made.vs, made.hs_spikes, made.vs_spikes};
    return answer(words, sizeof words) && answer(counter_ticks, sizeof counter_ticks) &&
           answer(counter_calls, sizeof counter_calls);
}

int main(void) {
    in = semihost_open("/dev/stdin", SEMIHOST_READ);
    out = semihost_open("/dev/stdout", SEMIHOST_WRITE);
    onboard *model = states_make();
    if (in < 0 || out < 0 || !model) return FAILED;
    counter_start();
    const uint32_t known = counter_known();
    uint32_t next = 0, command = 0;
    while (semihost_read(in, &command, sizeof command) && command != END) {
        const uint32_t magic = MAGIC, used = chip_stack_used();
        const uint32_t hello[7] = {MAGIC, ONBOARD_ROWS, ONBOARD_COLUMNS, COUNTER_STAGES, ONBOARD_STATE_BYTES,
                                   counter_cost, known};
        int done = 0;
        if (command == HELLO) done = answer(hello, sizeof hello);
        if (command == STACK) done = answer(&used, sizeof used);
        if (command == RESET) {
            onboard_reset(model);
            done = answer(&magic, sizeof magic);
        }
        if (command == FRAME) {
            done = frame(model, camera_ring[next]);
            next = (next + 1u) % CAMERA_FRAMES;
        }
        if (!done) return FAILED;
    }
    return 0;
}
