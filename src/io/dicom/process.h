/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A process of osteon-dicom and the messages that it sends.
 *
 *   start --request--> osteon-dicom --pipe--> next (a message) --> payload ... --> end (killed and reaped)
 *
 * Limits are set before the program starts: on address space, processor time and the number of descriptors; no file
 * can be written (RLIMIT_FSIZE 0). The process inherits only the descriptors of the request, the pipe and /dev/null,
 * has no terminal output, and is killed when its parent dies. Each message must be complete within a time limit.
 * Everything that the process sends is treated as hostile.
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
 * Returns the number of processes for work that consists of `parts` parts: at most the number of processors, and at
 * most 4.
 */
size_t ost_dicom_process_count(size_t parts);

/*
 * The options for starting processes. A zero-initialised struct selects the installed program and the default time
 * limit.
 */
typedef struct ost_dicom_launch {
    const char *program; /* path of osteon-dicom; if NULL, the program is searched */
    int seconds;         /* time limit for one message; 0 means OST_DICOM_SECONDS */
} ost_dicom_launch;

typedef struct ost_dicom_process {
    pid_t pid; /* process ID; 0 if there is no process */
    int pipe;  /* descriptor of the pipe; -1 if there is no pipe */
    int seconds;
    int64_t deadline; /* time by which the current message must be complete, in ns of ost_clock_ns */
} ost_dicom_process;

/*
 * Finds the program. If the environment variable OSTEON_LIBEXECDIR is set, the program is searched in this folder. If
 * not, it is searched in the installed folder, and then in the folder of the running program. Returns
 * OST_ERR_UNAVAILABLE if the program is not found. The message names `input`.
 */
ost_status ost_dicom_program(const char *input, char path[OST_DICOM_PATH_MAX], ost_error *err);

/*
 * Starts a process. `request` is the descriptor of an open file at position 0. `images` is the number of images in
 * the request, which determines the limit of processor time. The function initialises *out; after a failure, *out may
 * be passed to ost_dicom_process_end.
 */
ost_status ost_dicom_process_start(const ost_dicom_launch *launch, int request, size_t images, ost_dicom_process *out,
                                   ost_error *err);

/*
 * Reads the header of the next message. `file` is the input file that error messages name. `pixel_bytes` is the size
 * that a message of type PIXELS must have. Returns OST_ERR_INPUT if the process fails, exceeds its time, or sends an
 * undefined type or a wrong size.
 */
ost_status ost_dicom_process_next(ost_dicom_process *process, const char *file, size_t pixel_bytes,
                                  ost_dicom_message *out, ost_error *err);
/* Reads `size` bytes of the current message's payload. */
ost_status ost_dicom_process_read(ost_dicom_process *process, const char *file, void *to, size_t size,
                                  ost_error *err);
/*
 * Returns OST_ERR_INPUT. The error message names the file and states what is wrong with the message that the process
 * sent.
 */
ost_status ost_dicom_process_nonsense(const char *file, const char *what, ost_error *err);

/* Kills the process, waits for its end, and closes the pipe. */
void ost_dicom_process_end(ost_dicom_process *process);

#endif
