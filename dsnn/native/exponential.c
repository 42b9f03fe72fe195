/* The exponential, with equal bits on every machine: dsnn/exponential.py writes the same operations in Python. */
#include <string.h>

#include "dsnn.h"

#define LN2_HIGH 6.93147180369123816490e-01 /* the first 32 bits of ln 2: times a small whole number it is exact */
#define LN2_LOW 1.90821492927058770002e-10  /* the rest */
#define PER_LN2 1.44269504088896338700e+00
#define TERMS 13

/* 1 / i!: the Taylor series, whose next term is below 1e-17 for |r| <= ln(2) / 2. */
static const double inverse_factorial[TERMS + 1] = {
    1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0, 1.0 / 40320.0, 1.0 / 362880.0,
    1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0,
};

/* 2 to the power k, -1022 <= k <= 1023: an exponent without a fraction. */
static double power_of_two(int32_t k)
{
    const uint64_t word = (uint64_t)(k + 1023) << 52;
    double power;
    memcpy(&power, &word, sizeof power);
    return power;
}

double vision_exp(double x)
{
    double r, sum;
    int32_t k;
    int i;
    if (!(x >= -708.0)) /* not a number, too */
        return x < -708.0 ? 0.0 : x;
    if (x > 709.0)
        return 1e308 * 10.0;
    k = (int32_t)(x * PER_LN2 + (x < 0.0 ? -0.5 : 0.5));
    r = (x - k * LN2_HIGH) - k * LN2_LOW;
    sum = inverse_factorial[TERMS];
    for (i = TERMS - 1; i >= 0; i--)
        sum = inverse_factorial[i] + r * sum;
    return sum * power_of_two(k);
}
