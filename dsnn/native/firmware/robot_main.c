/* An example of the robot's own program. Four places are marked PLACE: what is there depends on the robot's board. */

#include <stdint.h>

#include "onboard_config.h"

#include "camera.h"
#include "chip.h"
#include "onboard.h"
#include "states.h"


/* PLACE of the board: clock at full speed with its flash waits, camera over its I2C bus and DMA, UART of the motors. */
static void board_start(void) {
}

/* PLACE of the camera: wait until the DMA controller has filled a frame of the ring, and say which. */
static uint32_t camera_wait(void) {
    static volatile uint32_t ready; /* the DMA interrupt would move this on */
    return ready % CAMERA_FRAMES;
}

/* PLACE of the behaviour: wheels' powers from the potentials (Q15) and spikes; here, turn with what moves. */
static int32_t wheel_difference(const onboard_answer *seen) {
    return seen->hs_spikes;
}

/* PLACE of the motors: send a command over the UART. */
static void motors_drive(int32_t difference) {
    (void)difference;
}

int main(void) {
    board_start();
    onboard *model = states_make();
    if (!model) return 1;
    for (;;) {
        onboard_answer seen;
        onboard_step(model, camera_luma(camera_ring[camera_wait()]), &seen);
        motors_drive(wheel_difference(&seen));
    }
}

/* There is nothing to go back to: stand still, for a debugger or a watchdog. */
void chip_exit(int status) {
    (void)status;
    for (;;) {
    }
}
