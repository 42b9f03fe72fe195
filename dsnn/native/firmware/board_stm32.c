/* An STM32F427 at 180 MHz by its own oscillator, and USART1 that sends on pin PA9.
 *
 * Written after the reference manual RM0090, and compiled by the tests; no test runs it, as no emulator here has this chip's
 * clock tree. PLACE marks what depends on your board. Where the PLL does not start, the program goes on at the oscillator's
 * 16 MHz, and says so by board_clock_hz.
 */

#include <stdint.h>

#include "board.h"
#include "chip.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define RCC_CR REGISTER(0x40023800u)
#define RCC_PLLCFGR REGISTER(0x40023804u)
#define RCC_CFGR REGISTER(0x40023808u)
#define RCC_AHB1ENR REGISTER(0x40023830u)
#define RCC_APB1ENR REGISTER(0x40023840u)
#define RCC_APB2ENR REGISTER(0x40023844u)
#define PWR_CR REGISTER(0x40007000u)
#define PWR_CSR REGISTER(0x40007004u)
#define FLASH_ACR REGISTER(0x40023C00u)
#define GPIOA_MODER REGISTER(0x40020000u)
#define GPIOA_AFRH REGISTER(0x40020024u)
#define USART1_SR REGISTER(0x40011000u)
#define USART1_DR REGISTER(0x40011004u)
#define USART1_BRR REGISTER(0x40011008u)
#define USART1_CR1 REGISTER(0x4001100Cu)

#define HSI_HZ 16000000u
#define FULL_HZ 180000000u
#define BAUD 115200u
#define TRIES 1000000u

#ifndef BOARD_WAITS
#define BOARD_WAITS 5u /* of the flash: what 180 MHz needs at 2.7 to 3.6 V; more may be set, to see what they cost */
#endif

const char board_name[] = "stm32f427";
static uint32_t clock_hz = HSI_HZ, usart_hz = HSI_HZ;

static int becomes(volatile uint32_t *place, uint32_t mask, uint32_t value) {
    for (uint32_t i = 0; i < TRIES; i++) {
        if ((*place & mask) == value) return 1;
    }
    return 0;
}

/* PLACE of the clock: 16 MHz / 16 x 360 / 2, with the regulator's over-drive. A crystal is more exact: here 1 %. */
static void clock_start(void) {
    RCC_APB1ENR |= 1u << 28; /* power controller */
    PWR_CR |= 3u << 14; /* regulator at scale 1 */
    RCC_PLLCFGR = 16u | 360u << 6 | 0u << 16 | 0u << 22 | 8u << 24; /* M, N, P = 2, of the HSI, Q */
    RCC_CR |= 1u << 24;
    if (!becomes(&RCC_CR, 1u << 25, 1u << 25)) return;
    PWR_CR |= 1u << 16; /* over-drive on, then switched to */
    if (!becomes(&PWR_CSR, 1u << 16, 1u << 16)) return;
    PWR_CR |= 1u << 17;
    if (!becomes(&PWR_CSR, 1u << 17, 1u << 17)) return;
    FLASH_ACR = BOARD_WAITS | 1u << 8 | 1u << 9 | 1u << 10; /* prefetch, instruction cache, data cache */
    if (!becomes(&FLASH_ACR, 15u, BOARD_WAITS)) return;
    RCC_CFGR = 5u << 10 | 4u << 13; /* APB1 at a quarter, APB2 at a half */
    RCC_CFGR |= 2u; /* the PLL */
    if (!becomes(&RCC_CFGR, 3u << 2, 2u << 2)) return;
    clock_hz = FULL_HZ;
    usart_hz = FULL_HZ / 2u;
}

/* PLACE of the serial line: USART1 on PA9 (alternate function 7). */
static void line_start(void) {
    RCC_AHB1ENR |= 1u; /* port A */
    RCC_APB2ENR |= 1u << 4; /* USART1 */
    GPIOA_MODER = (GPIOA_MODER & ~(3u << 18)) | 2u << 18;
    GPIOA_AFRH = (GPIOA_AFRH & ~(15u << 4)) | 7u << 4;
    USART1_BRR = (usart_hz + BAUD / 2u) / BAUD;
    USART1_CR1 = 1u << 13 | 1u << 3; /* on, and sends */
}

void board_start(void) {
    clock_start();
    line_start();
}

void board_send(const char *text, uint32_t length) {
    for (uint32_t i = 0; i < length; i++) {
        while (!(USART1_SR & 1u << 7)) {
        }
        USART1_DR = (uint8_t)text[i];
    }
}

int32_t board_clock_hz(void) {
    return (int32_t)clock_hz;
}

int32_t board_flash_waits(void) {
    return (int32_t)(FLASH_ACR & 15u);
}

/* Everything is sent: stand still. */
void chip_exit(int status) {
    (void)status;
    for (;;) {
    }
}
