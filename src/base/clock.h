/* The clock that times are taken with: monotonic, so no change of the date is seen. */
#ifndef BASE_CLOCK_H
#define BASE_CLOCK_H

/* Milliseconds since some moment in the past. Any thread. */
double clock_ms(void);

#endif
