/* Cycles of the processor: see cycles.h. */

#include <stdint.h>

#include "cycles.h"

#define DEMCR (*(volatile uint32_t *)0xE000EDFCu)
#define DWT_CTRL (*(volatile uint32_t *)0xE0001000u)
#define DWT_CYCCNT (*(volatile uint32_t *)0xE0001004u)
#define TRCENA (1u << 24)
#define NOCYCCNT (1u << 25)
#define CYCCNTENA 1u

int cycles_start(void) {
    DEMCR |= TRCENA;
    DWT_CYCCNT = 0;
    DWT_CTRL |= CYCCNTENA;
    if ((DWT_CTRL & (NOCYCCNT | CYCCNTENA)) != CYCCNTENA) return 0;
    const uint32_t before = DWT_CYCCNT;
    for (uint32_t i = 0; i < 16u; i++) __asm__ volatile("nop");
    return DWT_CYCCNT != before;
}

uint32_t cycles_now(void) {
    return DWT_CYCCNT;
}
