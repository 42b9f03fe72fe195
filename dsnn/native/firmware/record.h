/* Records of the serial line: text that survives a cable, one line each, so that any terminal program can keep it.
 *
 *     $kind,field,field*CRC4<carriage return><line feed>
 *
 * A field is a whole number in decimal digits, a word of a-z, 0-9 and '-', or '-' alone where there is no value. CRC4 is the
 * CRC-16 of what is between '$' and '*' (polynomial 0x1021 from 0xFFFF, "CCITT-FALSE"), four digits of 0-9, A-F.
 * experiments/robot/firmware.py reads them.
 */

#ifndef RECORD_H
#define RECORD_H

#include <stdint.h>

#define RECORD_LONGEST 128u /* characters of a line, its end included */

typedef struct {
    char text[RECORD_LONGEST];
    uint32_t length;
    int legal; /* 0: too long, or a word with another character */
} record;

/* Begin a record; `kind` and words are ASCII text that ends with a 0. */
void record_begin(record *line, const char *kind);

void record_signed(record *line, int32_t value);
void record_unsigned(record *line, uint32_t value);
void record_word(record *line, const char *word);

/* '-': there is no value. */
void record_none(record *line);

/* End the line. Its length in `text`, which has no 0 at its end; 0 where it is not legal. */
uint32_t record_end(record *line);

#endif
