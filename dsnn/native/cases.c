/* Runs cases from standard input and writes the answers, both as plain bytes in this machine's order: for tests.
 *
 * tests/helpers/native_cases.py writes the input. Each case's memory is asked for with its exact size, at an odd address, so
 * that a sanitizer sees every byte that is read or written beside it.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dsnn.h"
#include "onboard.h"

static void take(void *to, size_t size)
{
    if (fread(to, 1, size, stdin) != size)
        exit(3);
}

static void give(const void *from, size_t size)
{
    if (fwrite(from, 1, size, stdout) != size)
        exit(4);
}

static void *fresh(size_t size)
{
    void *memory = malloc(size == 0 ? 1 : size);
    if (memory == NULL)
        exit(5);
    memset(memory, 0xa5, size);
    return memory;
}

static float *table(int32_t count)
{
    float *values = fresh((size_t)count * sizeof(float));
    take(values, (size_t)count * sizeof(float));
    return values;
}

typedef struct {
    int32_t rows, columns, frames, floats; /* floats: whether the frames are */
} film;

static size_t frame_size(const film *f)
{
    return (size_t)f->rows * (size_t)f->columns * (f->floats ? sizeof(float) : 1);
}

static void run_dsnn(void)
{
    dsnn_config c;
    film f;
    float *tables[4];
    unsigned char *memory, *frame;
    dsnn *model;
    size_t size, cells;
    int32_t i, t;
    float *maps[4];
    take(&f, sizeof f);
    memset(&c, 0, sizeof c);
    c.rows = f.rows;
    c.columns = f.columns;
    take(&c.n_p, 9 * sizeof(int32_t));  /* to common */
    take(&c.w_i, 4 * sizeof(float));    /* to left_slow */
    take(&c.alpha_mp, 4 * sizeof(double)); /* to t_sp */
    c.residues = tables[0] = table(c.n_p);
    c.kernel_e = tables[1] = table(4 * c.d + 1);
    c.kernel_i = tables[2] = table(8 * c.d + 1);
    c.alphas = tables[3] = table(c.n_con);
    size = dsnn_size(&c);
    memory = fresh(size + 1);
    if (size == 0 || dsnn_make(memory + 1, size - 1, &c) != NULL)
        exit(6);
    model = dsnn_make(memory + 1, size, &c);
    for (i = 0; i < 4; i++)
        free(tables[i]); /* copied by now */
    frame = fresh(frame_size(&f));
    cells = (size_t)f.rows * (size_t)f.columns;
    for (t = 0; t < f.frames; t++) {
        dsnn_answer answer;
        double azimuth;
        take(frame, frame_size(&f));
        if (f.floats)
            dsnn_step_f32(model, (const float *)frame, &answer);
        else
            dsnn_step_u8(model, frame, &answer);
        azimuth = dsnn_azimuth(model);
        give(&answer.hs, sizeof(double));
        give(&answer.vs, sizeof(double));
        give(&answer.hs_spikes, sizeof(int32_t));
        give(&answer.vs_spikes, sizeof(int32_t));
        give(&azimuth, sizeof azimuth);
    }
    for (i = 0; i < 4; i++)
        maps[i] = fresh(cells * sizeof(float));
    dsnn_maps(model, maps[0], maps[1], maps[2], maps[3]);
    for (i = 0; i < 4; i++) {
        give(maps[i], cells * sizeof(float));
        free(maps[i]);
    }
    dsnn_reset(model);
    free(frame);
    free(memory);
}

static void run_lgmd1(void)
{
    lgmd1_config c;
    film f;
    unsigned char *memory, *frame;
    lgmd1 *model;
    size_t size;
    int32_t t;
    take(&f, sizeof f);
    memset(&c, 0, sizeof c);
    c.rows = f.rows;
    c.columns = f.columns;
    take(&c.w_i, 4 * sizeof(float));   /* to t_g */
    take(&c.c_w, 4 * sizeof(double));  /* to t_sp */
    size = lgmd1_size(&c);
    memory = fresh(size + 3);
    if (size == 0 || lgmd1_make(memory + 3, size - 1, &c) != NULL)
        exit(6);
    model = lgmd1_make(memory + 3, size, &c);
    frame = fresh(frame_size(&f));
    for (t = 0; t < f.frames; t++) {
        lgmd1_answer answer;
        take(frame, frame_size(&f));
        if (f.floats)
            lgmd1_step_f32(model, (const float *)frame, &answer);
        else
            lgmd1_step_u8(model, frame, &answer);
        give(&answer.potential, sizeof(double));
        give(&answer.spike, sizeof(int32_t));
    }
    lgmd1_reset(model);
    free(frame);
    free(memory);
}

/* A table of entries of `width` bytes, its count before it. */
static void *counted(size_t width)
{
    int32_t count;
    void *values;
    take(&count, sizeof count);
    values = fresh((size_t)count * width);
    take(values, (size_t)count * width);
    return values;
}

static void run_onboard(void)
{
    onboard_config c;
    film f;
    void *tables[8];
    unsigned char *memory, *frame;
    onboard *model;
    size_t size, cells;
    int32_t i, t, *maps[4];
    take(&f, sizeof f);
    memset(&c, 0, sizeof c);
    take(&c.rows, 26 * sizeof(int32_t)); /* to alpha_mp */
    take(&c.plate_limit, sizeof c.plate_limit);
    take(&c.plate_shift, 4 * sizeof(int32_t)); /* to thresholds_count */
    c.residues = tables[0] = counted(2);
    c.kernel_e = tables[1] = counted(2);
    c.kernel_i = tables[2] = counted(2);
    c.alphas = tables[3] = counted(4);
    c.decode = tables[4] = counted(2);
    c.decay = tables[5] = counted(1);
    c.sigmoid = tables[6] = counted(2);
    c.thresholds = tables[7] = counted(2);
    size = onboard_size(&c);
    memory = fresh(size + 1);
    if (size == 0 || onboard_make(memory + 1, size - 1, &c) != NULL)
        exit(6);
    model = onboard_make(memory + 1, size, &c);
    frame = fresh(frame_size(&f));
    cells = (size_t)f.rows * (size_t)f.columns;
    for (t = 0; t < f.frames; t++) {
        onboard_answer answer;
        take(frame, frame_size(&f));
        onboard_step(model, frame, &answer);
        give(&answer, sizeof answer);
    }
    for (i = 0; i < 4; i++)
        maps[i] = fresh(cells * sizeof(int32_t));
    onboard_maps(model, maps[0], maps[1], maps[2], maps[3]);
    for (i = 0; i < 4; i++) {
        give(maps[i], cells * sizeof(int32_t));
        free(maps[i]);
    }
    onboard_reset(model);
    for (i = 0; i < 8; i++)
        free(tables[i]);
    free(frame);
    free(memory);
}

int main(void)
{
    int32_t kind;
    while (fread(&kind, sizeof kind, 1, stdin) == 1) {
        if (kind == 0)
            run_dsnn();
        else if (kind == 2)
            run_onboard();
        else
            run_lgmd1();
    }
    return 0;
}
