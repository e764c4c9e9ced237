/* Prices from measured frames. */
#ifndef STP_PLAN_FIT_H
#define STP_PLAN_FIT_H

#include <stddef.h>

#define FIT_TRUST 0.2 /* in known prices, as a share of the rows' own weight */

/* Prices >= 0: predicted = sum over the terms of amount[i * terms + t] * price[t], with the least
 *   sum of (predicted - measured)^2 / measured
 *   + FIT_TRUST * sum over the terms of (price - s known)^2 * sum of amount^2 / measured.
 * So relative residuals weigh as long as the rows take: what is off in a long one costs more.
 * A few rows do not tell all terms apart; where they do not, prices keep the proportions of known
 * ones, those of another device perhaps, times the s that suits the rows best. A term that no row
 * has any of gets s known. known: NULL for none, and then the first sum alone is the least, and a
 * term without which the rest explains as much gets 0. rows > 0, terms <= 16; measured values are
 * above 0. */
void fit_prices(size_t rows, unsigned terms, const double *amount, const double *measured,
                const double *known, double *price);

#endif
