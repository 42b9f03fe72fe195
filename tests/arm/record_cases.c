/* Writes the records that standard input asks for, a step a line: begin KIND, word TEXT, signed N, unsigned N, none, end. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "record.h"

int main(void)
{
    static char step[256];
    record *const line = malloc(sizeof *line); /* so that a sanitizer sees every byte beside it */
    if (line == NULL)
        return 1;
    while (fgets(step, sizeof step, stdin) != NULL) {
        char *const space = strchr(step, ' ');
        const char *const given = space != NULL ? space + 1 : "";
        step[strcspn(step, "\n")] = 0;
        if (strncmp(step, "begin", 5) == 0)
            record_begin(line, given);
        else if (strncmp(step, "word", 4) == 0)
            record_word(line, given);
        else if (strncmp(step, "signed", 6) == 0)
            record_signed(line, (int32_t)strtol(given, NULL, 10));
        else if (strncmp(step, "unsigned", 8) == 0)
            record_unsigned(line, (uint32_t)strtoul(given, NULL, 10));
        else if (strncmp(step, "none", 4) == 0)
            record_none(line);
        else {
            const uint32_t length = record_end(line);
            if (length == 0)
                fputs("not legal\n", stdout);
            fwrite(line->text, 1, length, stdout);
        }
    }
    free(line);
    return 0;
}
