/* What the self-measuring program needs of a board: its clock, and a serial line that sends. */

#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

extern const char board_name[]; /* a word of record.h */

/* Clock at full speed with its flash waits, and the serial line at 115,200 baud, 8 bits, no parity, one stop bit. */
void board_start(void);

/* Send characters; returns when the last is on its way. */
void board_send(const char *text, uint32_t length);

/* The processor's clock, 1/s, and the wait states that its flash is set to; -1 where there is no such number. */
int32_t board_clock_hz(void);
int32_t board_flash_waits(void);

#endif
