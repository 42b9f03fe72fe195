/* Start of the chip: vector table, initialised and zeroed memory, tables in RAM, a painted stack, then main().
 *
 * Written for ARM Cortex-M4 (ARMv7-M architecture reference manual, B1.5: the vector table begins with the initial
 * stack pointer and the reset handler). The addresses come from the linker script.
 */

#include <stddef.h>
#include <stdint.h>

#include "chip.h"

extern uint32_t chip_data_load[], chip_data_start[], chip_data_end[];
extern uint32_t chip_tables_load[], chip_tables_start[], chip_tables_end[];
extern uint32_t chip_bss_start[], chip_bss_end[];

int main(void);
void chip_reset(void);
static void fault(void);

/* Entries 1 to 15; interrupts of peripherals belong to the robot's own code. Entry 0 is the stack's top. */
typedef struct {
    uint32_t *stack;
    void (*handlers[15])(void);
} vector_table;

__attribute__((section(".vectors"), used)) const vector_table chip_vectors = {
    chip_stack_top,
    {chip_reset, fault, fault, fault, fault, fault, 0, 0, 0, 0, fault, fault, 0, fault, fault},
};

static void copy(const uint32_t *load, uint32_t *word, const uint32_t *end) {
    while (word < end) *word++ = *load++;
}

void chip_reset(void) {
    copy(chip_data_load, chip_data_start, chip_data_end);
    copy(chip_tables_load, chip_tables_start, chip_tables_end);
    for (uint32_t *word = chip_bss_start; word < chip_bss_end; word++) *word = 0; /* not ring, states and stack */
    chip_paint_stack();
    chip_exit(main());
}

static void fault(void) {
    chip_exit(CHIP_FAULT);
}
