/* Records of the serial line: see record.h. */

#include <stdint.h>

#include "record.h"

#define TAIL 7u /* characters of "*CRC4" and the line's end */

static void put(record *line, char character) {
    if (line->length < RECORD_LONGEST - TAIL)
        line->text[line->length++] = character;
    else
        line->legal = 0;
}

static void word(record *line, const char *from) {
    if (!*from) line->legal = 0;
    for (; *from && line->legal; from++) {
        const char c = *from;
        if (!((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-')) line->legal = 0;
        put(line, c);
    }
}

static void digits(record *line, uint32_t value) {
    char reversed[10];
    uint32_t count = 0;
    do {
        reversed[count++] = (char)('0' + value % 10u);
        value /= 10u;
    } while (value);
    while (count) put(line, reversed[--count]);
}

void record_begin(record *line, const char *kind) {
    line->length = 0;
    line->legal = 1;
    put(line, '$');
    word(line, kind);
}

void record_signed(record *line, int32_t value) {
    const uint32_t bits = (uint32_t)value;
    put(line, ',');
    if (value < 0) put(line, '-');
    digits(line, value < 0 ? 0u - bits : bits);
}

void record_unsigned(record *line, uint32_t value) {
    put(line, ',');
    digits(line, value);
}

void record_word(record *line, const char *text) {
    put(line, ',');
    word(line, text);
}

void record_none(record *line) {
    record_word(line, "-");
}

uint32_t record_end(record *line) {
    static const char hex[] = "0123456789ABCDEF";
    uint32_t crc = 0xFFFFu, i, bit;
    if (!line->legal) return 0;
    for (i = 1; i < line->length; i++) {
        crc ^= (uint32_t)(uint8_t)line->text[i] << 8;
        for (bit = 0; bit < 8; bit++) crc = (crc & 0x8000u ? crc << 1 ^ 0x1021u : crc << 1) & 0xFFFFu;
    }
    line->text[line->length++] = '*';
    for (i = 0; i < 4; i++) line->text[line->length++] = hex[crc >> (12u - 4u * i) & 15u];
    line->text[line->length++] = '\r';
    line->text[line->length++] = '\n';
    return line->length;
}
