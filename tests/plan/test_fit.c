/* Prices from measurements: known prices are found again, and what is found is a minimum. */
#include "plans.h"

#include "plan/fit.h"

#define ROWS  24
#define TERMS 6

static void make_amounts(uint32_t *state, double amount[ROWS * TERMS])
{
    for (int i = 0; i < ROWS * TERMS; i++)
        amount[i] = floor(uniform(state) * pow(10, 1 + i % TERMS)); /* scales far apart */
}

static void test_known_prices(void **state)
{
    uint32_t seed = 7;
    for (int trial = 0; trial < 50; trial++) {
        double amount[ROWS * TERMS], known[TERMS], measured[ROWS], price[TERMS];
        make_amounts(&seed, amount);
        for (int t = 0; t < TERMS; t++)
            known[t] = uniform(&seed) < 0.3 ? 0 : uniform(&seed) * pow(10, -t);
        known[trial % TERMS] = 1;
        for (int i = 0; i < ROWS; i++) {
            measured[i] = 1e-3;
            for (int t = 0; t < TERMS; t++)
                measured[i] += amount[i * TERMS + t] * known[t];
        }
        fit_prices(ROWS, TERMS, amount, measured, NULL, price);
        for (int i = 0; i < ROWS; i++) {
            double predicted = 0;
            for (int t = 0; t < TERMS; t++)
                predicted += amount[i * TERMS + t] * price[t];
            assert_true(fabs(predicted - measured[i]) <= 0.01 * measured[i]);
        }
    }
}

static double slope(const double *amount, const double *measured, const double *price, int term)
{
    double sum = 0;
    for (int i = 0; i < ROWS; i++) {
        double predicted = 0;
        for (int t = 0; t < TERMS; t++)
            predicted += amount[i * TERMS + t] * price[t];
        sum += (predicted - measured[i]) * amount[i * TERMS + term] / measured[i];
    }
    return sum;
}

static double length(const double *amount, const double *measured, int term)
{
    double sum = 0;
    for (int i = 0; i < ROWS; i++)
        sum += pow(amount[i * TERMS + term], 2) / measured[i];
    return sqrt(sum);
}

/* Karush, Kuhn, Tucker: no slope where the price is positive, none downwards where it is 0. */
static void test_minimum(void **state)
{
    uint32_t seed = 11;
    for (int trial = 0; trial < 50; trial++) {
        double amount[ROWS * TERMS], measured[ROWS], price[TERMS];
        make_amounts(&seed, amount);
        for (int i = 0; i < ROWS; i++)
            measured[i] = 0.5 + uniform(&seed) * 100; /* as good as noise */
        fit_prices(ROWS, TERMS, amount, measured, NULL, price);
        for (int t = 0; t < TERMS; t++) {
            double s = slope(amount, measured, price, t) / length(amount, measured, t);
            assert_true(price[t] >= 0 && isfinite(price[t]));
            assert_true(s > -1e-5 && (price[t] == 0 || s < 1e-5));
        }
    }
}

static void test_absent_term(void **state)
{
    const double amount[] = { 2, 0, 4, 0, 6, 0 }, measured[] = { 1, 2, 3 };
    double price[2] = { -1, -1 };
    fit_prices(3, 2, amount, measured, NULL, price);
    assert_true(fabs(price[0] - 0.5) < 1e-9);
    assert_true(price[1] == 0);
}

/* Two terms that always come together: known prices say how they share what is measured. */
static void test_known_proportions(void **state)
{
    const double amount[] = { 2, 4, 0, 3, 6, 0, 5, 10, 0 }, measured[] = { 20, 30, 50 };
    const double known[] = { 4, 3, 7 };
    double price[3];
    fit_prices(3, 3, amount, measured, known, price);
    assert_true(fabs(price[0] - 4) < 1e-6 && fabs(price[1] - 3) < 1e-6);
    assert_true(fabs(price[2] - 7) < 1e-6); /* in no row: as known, times the same */
    const double twice[] = { 40, 60, 100 };
    fit_prices(3, 3, amount, twice, known, price);
    assert_true(fabs(price[0] - 8) < 1e-6 && fabs(price[1] - 6) < 1e-6 &&
                fabs(price[2] - 14) < 1e-6);
}

/* Wrong proportions only hold where rows say nothing: here they tell the terms apart. */
static void test_rows_outweigh(void **state)
{
    uint32_t seed = 5;
    double amount[ROWS * TERMS], measured[ROWS], price[TERMS], known[TERMS];
    for (int trial = 0; trial < 20; trial++) {
        for (int i = 0; i < ROWS * TERMS; i++)
            amount[i] = uniform(&seed) < 0.7 ? 0 : uniform(&seed);
        for (int i = 0; i < ROWS; i++) {
            amount[i * TERMS + i % TERMS] = 10;
            measured[i] = 0;
            for (int t = 0; t < TERMS; t++)
                measured[i] += amount[i * TERMS + t] * (t + 1);
        }
        for (int t = 0; t < TERMS; t++)
            known[t] = (t + 1) * (t % 2 ? 3 : 1); /* true ones lie between, after scaling */
        fit_prices(ROWS, TERMS, amount, measured, known, price);
        for (int t = 0; t < TERMS; t++)
            assert_true(fabs(price[t] / (t + 1) - 1) < 0.2);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_known_prices),  cmocka_unit_test(test_minimum),
        cmocka_unit_test(test_absent_term),   cmocka_unit_test(test_known_proportions),
        cmocka_unit_test(test_rows_outweigh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
