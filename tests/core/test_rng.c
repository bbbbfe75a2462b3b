/* rng: known answers and statistics of the counter-based random numbers.
 * dims: 2 */
#include "core/rng.h"
#include "test.h"

/* Known-answer vectors of philox4x32 with 10 rounds, published with Random123 (kat_vectors). */
TEST(known_answers)
{
    static const uint32_t counter[3][4] = {{0, 0, 0, 0},
                                           {0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu},
                                           {0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u}};
    static const uint32_t key[3][2] = {{0, 0}, {0xffffffffu, 0xffffffffu}, {0xa4093822u, 0x299f31d0u}};
    static const uint32_t expected[3][4] = {{0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u},
                                            {0x408f276du, 0x41c83b0eu, 0xa20bc7c6u, 0x6d5451fdu},
                                            {0xd16cfe09u, 0x94fdccebu, 0x5001e420u, 0x24126ea1u}};
    for (int k = 0; k < 3; k++) {
        uint32_t out[4];
        pdi_rng_philox(counter[k], key[k], out);
        for (int w = 0; w < 4; w++) CHECK_INT(out[w], expected[k][w]);
    }
}

/* The same vectors through the (seed, stream, counter) form: little-endian words. */
TEST(layout)
{
    CHECK(pdi_rng_u64(0, 0, 0) == 0xe169c58d6627e8d5ull);
    CHECK(pdi_rng_u64(0x299f31d0a4093822ull, 0x0370734413198a2eull, 0x85a308d3243f6a88ull) == 0x94fdccebd16cfe09ull);
}

/* n samples, one of seed, stream and counter running: mean, variance, bins and neighbour correlation. */
static void uniform_statistics(int which)
{
    enum { samples = 200000, bins = 64 };
    static int histogram[bins];
    double sum = 0.0, square = 0.0, product = 0.0, last = 0.5;
    memset(histogram, 0, sizeof histogram);
    for (int k = 0; k < samples; k++) {
        uint64_t run = (uint64_t)k;
        double x = pdi_rng_uniform(which == 0 ? run : 7, which == 1 ? run : 3, which == 2 ? run : 11);
        CHECK(x > 0.0 && x < 1.0);
        sum += x;
        square += (x - 0.5) * (x - 0.5);
        product += (x - 0.5) * (last - 0.5);
        last = x;
        histogram[(int)(x * bins)]++;
    }
    double chi2 = 0.0, mean_count = (double)samples / bins;
    for (int b = 0; b < bins; b++) chi2 += pow(histogram[b] - mean_count, 2.0) / mean_count;
    /* four standard deviations: mean 1/sqrt(12 n), variance 1/sqrt(180 n), product 1/(12 sqrt n) */
    double root = sqrt((double)samples);
    CHECK_NEAR(sum / samples, 0.5, 4.0 / (sqrt(12.0) * root));
    CHECK_NEAR(square / samples, 1.0 / 12.0, 4.0 / (sqrt(180.0) * root));
    CHECK_NEAR(product / samples, 0.0, 4.0 / (12.0 * root));
    CHECK_NEAR(chi2, bins - 1.0, 4.0 * sqrt(2.0 * (bins - 1.0)));
}

TEST(uniform_over_counters) { uniform_statistics(2); }
TEST(uniform_over_streams) { uniform_statistics(1); }
TEST(uniform_over_seeds) { uniform_statistics(0); }

/* Moments 0, 1, 0, 3 and independence of the pair. */
TEST(normal)
{
    int samples = 200000;
    double m1 = 0.0, m2 = 0.0, m3 = 0.0, m4 = 0.0, cross = 0.0, cross2 = 0.0;
    for (int k = 0; k < samples; k++) {
        double pair[2];
        pdi_rng_normal(42, 5, (uint64_t)k, pair);
        for (int c = 0; c < 2; c++) {
            m1 += pair[c];
            m2 += pair[c] * pair[c];
            m3 += pair[c] * pair[c] * pair[c];
            m4 += pair[c] * pair[c] * pair[c] * pair[c];
        }
        cross += pair[0] * pair[1];
        cross2 += (pair[0] * pair[0] - 1.0) * (pair[1] * pair[1] - 1.0);
    }
    double n = 2.0 * samples;
    CHECK_NEAR(m1 / n, 0.0, 4.0 / sqrt(n));
    CHECK_NEAR(m2 / n, 1.0, 4.0 * sqrt(2.0 / n));
    CHECK_NEAR(m3 / n, 0.0, 4.0 * sqrt(15.0 / n));
    CHECK_NEAR(m4 / n, 3.0, 4.0 * sqrt(96.0 / n));
    CHECK_NEAR(cross / samples, 0.0, 4.0 / sqrt((double)samples));
    CHECK_NEAR(cross2 / samples, 0.0, 8.0 / sqrt((double)samples));
}

/* No two of many (seed, stream, counter) triples give the same word: collisions of 64 bits are absent at this size. */
TEST(distinct)
{
    enum { side = 12, total = side * side * side };
    static uint64_t word[total];
    int count = 0;
    for (uint64_t a = 0; a < side; a++)
        for (uint64_t b = 0; b < side; b++)
            for (uint64_t c = 0; c < side; c++) word[count++] = pdi_rng_u64(a << 28, b << 28, c << 28);
    for (int i = 0; i < total; i++)
        for (int j = 0; j < i; j++)
            if (word[i] == word[j]) CHECK_INT(i, j);
    CHECK_INT(count, total);
}

TEST_MAIN(ENTRY(known_answers) ENTRY(layout) ENTRY(uniform_over_counters) ENTRY(uniform_over_streams)
          ENTRY(uniform_over_seeds) ENTRY(normal) ENTRY(distinct))
