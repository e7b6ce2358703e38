/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A process of osteon-dicom and the messages that it sends.
 *
 *   start --request--> osteon-dicom --pipe--> next (a message) --> payload ... --> end (killed and reaped)
 *
 * The process is limited before its program starts: address space, processor time, descriptors, and
 * no writable file (RLIMIT_FSIZE 0). It inherits no descriptor except the request, the pipe and
 * /dev/null, has no terminal output, and is killed when its parent dies. Each message must be complete
 * within a time limit. Everything that the process sends is treated as hostile.
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
/* Returns the number of processes for work that can be divided into `parts`: at most the processors, and at most 4. */
size_t ost_dicom_process_count(size_t parts);

/* How processes are started. Zero-initialised, it selects the installed program and the usual limit. */
typedef struct ost_dicom_launch {
    const char *program; /* path of osteon-dicom; NULL: searched */
    int seconds;         /* time for a message; 0: OST_DICOM_SECONDS */
} ost_dicom_launch;

typedef struct ost_dicom_process {
    pid_t pid; /* 0 if there is none */
    int pipe;  /* -1 if there is none */
    int seconds;
    int64_t deadline; /* of the current message; ns of ost_clock_ns */
} ost_dicom_process;

/*
 * Finds the program: in the folder OSTEON_LIBEXECDIR if this environment variable is set, else in the
 * installed folder, else next to the running program. Returns OST_ERR_UNAVAILABLE if it is in none of
 * them; input is named in the message.
 */
ost_status ost_dicom_program(const char *input, char path[OST_DICOM_PATH_MAX], ost_error *err);

/*
 * Starts a process with a request, an open file whose position is 0. images is the number of images of
 * the request, which sets the limit of processor time. *out is initialised here; after a failure it may
 * be passed to ost_dicom_process_end.
 */
ost_status ost_dicom_process_start(const ost_dicom_launch *launch, int request, size_t images, ost_dicom_process *out,
                                   ost_error *err);

/*
 * Reads the header of the next message. `file` is the input that the process is working on, for messages.
 * Returns OST_ERR_INPUT if the process fails, exceeds its time, or sends a type or a size that does not
 * exist; pixel_bytes is the size that a message of type PIXELS must have.
 */
ost_status ost_dicom_process_next(ost_dicom_process *process, const char *file, size_t pixel_bytes,
                                  ost_dicom_message *out, ost_error *err);
/* Reads `size` bytes of the current message. */
ost_status ost_dicom_process_read(ost_dicom_process *process, const char *file, void *to, size_t size,
                                  ost_error *err);
/* Returns OST_ERR_INPUT with a message that names the file and what is wrong with the process's message. */
ost_status ost_dicom_process_nonsense(const char *file, const char *what, ost_error *err);

/* Kills and reaps the process, and closes the pipe. Nothing remains to be done afterwards. */
void ost_dicom_process_end(ost_dicom_process *process);

#endif
