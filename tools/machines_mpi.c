/* Processes over MPI. A command that was not started by mpirun or srun does not touch it. */
#include <limits.h>
#include <mpi.h>
#include <stdlib.h>

#include "machines.h"

/* The rank as the launcher tells it: Open MPI's own, PMIx (srun --mpi=pmix), PMI (srun). NULL:
 * there is no launcher. */
static const char *launched_rank(void)
{
    static const char *const names[] = { "OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK" };
    const char *rank = NULL;
    for (unsigned i = 0; !rank && i < sizeof names / sizeof *names; i++)
        rank = getenv(names[i]);
    return rank;
}

static enum stp_result agree(void *, enum stp_result mine)
{
    int worst = (int)mine;
    MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    return (enum stp_result)worst;
}

static void reduce_some(MPI_Op operation, int64_t *values, int count, bool to_all)
{
    int rank;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (to_all)
        MPI_Allreduce(MPI_IN_PLACE, values, count, MPI_INT64_T, operation, MPI_COMM_WORLD);
    else
        MPI_Reduce(rank == 0 ? MPI_IN_PLACE : values, rank == 0 ? values : NULL, count, MPI_INT64_T,
                   operation, 0, MPI_COMM_WORLD);
}

/* MPI counts in ints. Its own errors end all processes: that is its default. */
static void reduce(void *, enum stp_reduction reduction, int64_t *values, size_t count, bool to_all)
{
    MPI_Op operation = reduction == STP_REDUCE_SUM ? MPI_SUM : MPI_MIN;
    for (size_t at = 0; at < count; at += INT_MAX) {
        size_t left = count - at;
        reduce_some(operation, values + at, left < INT_MAX ? (int)left : INT_MAX, to_all);
    }
}

void machines_open(struct stp_machines *exchange)
{
    int rank = 0, count = 1, provided;
    if (launched_rank()) {
        MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &provided);
        MPI_Comm_rank(MPI_COMM_WORLD, &rank);
        MPI_Comm_size(MPI_COMM_WORLD, &count);
    }
    *exchange = (struct stp_machines){
        .rank = (unsigned)rank, .count = (unsigned)count, .agree = agree, .reduce = reduce
    };
}

void machines_close(struct stp_machines *)
{
    int started = 0;
    MPI_Initialized(&started);
    if (started)
        MPI_Finalize();
}

bool machines_possible(void)
{
    return true;
}

bool machines_speaks(void)
{
    const char *rank = launched_rank();
    return !rank || atoi(rank) == 0;
}

int machines_agree(const struct stp_machines *exchange, struct console *console, int status)
{
    int worst = status, first = status ? (int)exchange->rank : INT_MAX;
    if (exchange->count == 1)
        return status;
    MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (first == (int)exchange->rank)
        console_release(console, exchange->rank);
    return worst;
}
