/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs osteon-dicom in a child process and receives its messages.
 *
 *   start --request--> osteon-dicom --pipe--> next (a message) --> payload ... --> end (killed and reaped)
 *
 * Before the program starts, limits are set on its address space, processor time and number of descriptors, and writing
 * files is disabled (RLIMIT_FSIZE 0). The process inherits only three descriptors (the request, the pipe and
 * /dev/null), and is killed when its parent dies. Each message must be complete within a time limit. All data from the
 * process are treated as hostile.
 */
#ifndef OST_IO_DICOM_PROCESS_H
#define OST_IO_DICOM_PROCESS_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include <osteon/status.h>

#include "io/dicom/protocol.h"

enum { OST_DICOM_SECONDS = 60 };

enum { OST_DICOM_PROCESSES_MAX = 4 };
/*
 * Returns the number of processes to start for `parts` units of work: at most the number of processors, and at most 4.
 */
size_t ost_dicom_process_count(size_t parts);

/* Options for starting processes. */
typedef struct ost_dicom_launch {
    const char *program; /* path of osteon-dicom, as found by ost_dicom_program */
    int seconds;         /* time limit for one message; 0 means OST_DICOM_SECONDS */
} ost_dicom_launch;

typedef struct ost_dicom_process {
    pid_t pid; /* process ID; 0 if there is no process */
    int pipe;  /* descriptor of the pipe; -1 if there is no pipe */
    int seconds;
    int64_t deadline; /* deadline of the current message, in ns of ost_clock_ns */
} ost_dicom_process;

/*
 * Finds osteon-dicom. Looks in the folder OSTEON_LIBEXECDIR if this environment variable is set, otherwise in the
 * installation folder and then in the folder of the running program. Returns OST_ERR_UNAVAILABLE, with a message that
 * names `input`, if the program is not found.
 */
ost_status ost_dicom_program(const char *input, char path[OST_DICOM_PATH_MAX], ost_error *err);

/*
 * Starts a process. `request` is the descriptor of an open file at position 0. `images` is the number of images in the
 * request; this number determines the limit on processor time. *out is initialised in all cases, and may be passed to
 * ost_dicom_process_end even after a failure.
 */
ost_status ost_dicom_process_start(const ost_dicom_launch *launch, int request, size_t images, ost_dicom_process *out,
                                   ost_error *err);

/*
 * Reads the header of the next message. `file` is the input file to name in error messages. `pixel_bytes` is the
 * required payload size of a message of type PIXELS. Returns OST_ERR_INPUT if the process fails or exceeds its time
 * limit, or if the message has an undefined type or a wrong size.
 */
ost_status ost_dicom_process_next(ost_dicom_process *process, const char *file, size_t pixel_bytes,
                                  ost_dicom_message *out, ost_error *err);
/* Reads `size` bytes of the current message's payload. */
ost_status ost_dicom_process_read(ost_dicom_process *process, const char *file, void *to, size_t size,
                                  ost_error *err);
/*
 * Returns OST_ERR_INPUT for an invalid message from the process. The error message contains the name of the file and
 * the description `what`.
 */
ost_status ost_dicom_process_nonsense(const char *file, const char *what, ost_error *err);

/* Kills the process, waits until it has exited, and closes the pipe. */
void ost_dicom_process_end(ost_dicom_process *process);

#endif
