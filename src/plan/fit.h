/* Prices from measured frames. */
#ifndef STP_PLAN_FIT_H
#define STP_PLAN_FIT_H

#include <stddef.h>

/* The prices >= 0 that leave the least sum of squares of (predicted - measured) / measured:
 * predicted = sum over the terms of amount[i * terms + t] * price[t]. A term that no row has any of
 * gets 0, and so does one without which the rest explains as much. rows > 0, terms <= 16; measured
 * values are above 0. */
void fit_prices(size_t rows, unsigned terms, const double *amount, const double *measured,
                double *price);

#endif
