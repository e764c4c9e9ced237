/* The processes that mpirun or srun started together. Two files implement it: with MPI, in a build
 * with -Dmpi=enabled, and alone. */
#ifndef TOOLS_MACHINES_H
#define TOOLS_MACHINES_H

#include <stipple/machines.h>

#include "cli.h"

/* Joins the others. exchange.count is 1 where there are none. */
void machines_open(struct stp_machines *exchange);
void machines_close(struct stp_machines *exchange);
/* Whether this build could have joined others. */
bool machines_possible(void);
/* Of processes that all say the same, the one that says it; known before machines_open. */
bool machines_speaks(void);
/* Collective: the worst status. Of those that failed the first prints the line that its console
 * holds (struct console, `held`). */
int machines_agree(const struct stp_machines *exchange, struct console *console, int status);

#endif
