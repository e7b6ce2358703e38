/* SPDX-License-Identifier: Apache-2.0 */
#include "app/film/file.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/printable.h"
#include "io/outfile.h"
#include "render/png.h"
#include "render/points/frame.h"

extern char **environ;

enum { NAME = 4096, LINE = 300, ENCODER_FD = 3 };

struct film_file {
    char *target;        /* owned; name of the video file; NULL if a command receives the video */
    bool folder;
    int fps;
    int width, height;   /* size of the video; 0 before the first frame */
    uint32_t *fitted;    /* owned; frame scaled to the size of the video */
    uint8_t *bytes;      /* owned; the last frame, encoded */
    size_t size;
    uint64_t frames;
    ost_outfile *out;    /* owned; the .y4m file, or the file that ffmpeg writes; NULL for other outputs */
    int pipe;            /* descriptor of the pipe to ffmpeg or to the command; -1 if there is no pipe */
    pid_t encoder;
    FILE *messages;      /* owned; receives ffmpeg's standard error; NULL if ffmpeg inherits it */
};

/* ------------------------------------------------------------------ names */

static bool ends(const char *name, const char *end)
{
    const size_t n = strlen(name), e = strlen(end);
    return n > e && strcmp(name + n - e, end) == 0;
}

static int write_all(int fd, const void *bytes, size_t size)
{
    const char *p = bytes;
    while (size) {
        const ssize_t n = write(fd, p, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n < 0 ? errno : EIO;
        p += n;
        size -= (size_t)n;
    }
    return 0;
}

/* --------------------------------------------------------------- programs */

/*
 * Searches PATH for a program. posix_spawn cannot be relied on to report a missing program: where vfork is implemented
 * as fork, posix_spawn reports success.
 */
static bool find_program(const char *name, char path[NAME])
{
    const char *from = getenv("PATH");
    struct stat st;
    for (const char *p = from ? from : "/usr/bin:/bin";; p++) {
        const size_t n = strcspn(p, ":");
        /* In PATH, an empty entry stands for the current folder. */
        const int length = snprintf(path, NAME, "%.*s%s%s", (int)n, p, n ? "/" : "", name);
        if (length < NAME && stat(path, &st) == 0 && S_ISREG(st.st_mode) && access(path, X_OK) == 0)
            return true;
        p += n;
        if (!*p)
            return false;
    }
}

static ost_status start(film_file *f, const char **argv, ost_error *err)
{
    int ends_of[2];
    posix_spawn_file_actions_t files;
    posix_spawnattr_t how;
    sigset_t none, usual;
    if (pipe2(ends_of, O_CLOEXEC) != 0)
        return ost_fail(err, OST_ERR_IO, "cannot create a pipe for a video: %s", strerror(errno));
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends_of[0], STDIN_FILENO);
    if (f->messages)
        posix_spawn_file_actions_adddup2(&files, fileno(f->messages), STDERR_FILENO);
    /* standard output may be needed for --json, so ffmpeg writes to standard error */
    posix_spawn_file_actions_adddup2(&files, STDERR_FILENO, STDOUT_FILENO);
    if (f->out)
        posix_spawn_file_actions_adddup2(&files, ost_outfile_descriptor(f->out), ENCODER_FD);
    posix_spawnattr_init(&how);
    sigemptyset(&none);
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    sigaddset(&usual, SIGXFSZ);
    posix_spawnattr_setsigmask(&how, &none);
    posix_spawnattr_setsigdefault(&how, &usual);
    /* the program gets its own process group, so that Ctrl-C does not stop it before the video is complete */
    posix_spawnattr_setpgroup(&how, 0);
    posix_spawnattr_setflags(&how, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    const int error = posix_spawn(&f->encoder, argv[0], &files, &how, (char *const *)(void *)argv, environ);
    posix_spawnattr_destroy(&how);
    posix_spawn_file_actions_destroy(&files);
    close(ends_of[0]);
    f->pipe = ends_of[1];
    if (!error)
        return OST_OK;
    f->encoder = 0;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "%s: %s", argv[0], strerror(error));
}

/*
 * Starts ffmpeg. ffmpeg writes to a descriptor that is already open, so that a symbolic link cannot redirect the
 * output. The descriptor is seekable, as the format .mp4 requires. ffmpeg's messages may contain arbitrary bytes of a
 * file name and must not reach the terminal, so ffmpeg writes them to a temporary file.
 */
static ost_status start_ffmpeg(film_file *f, const char *format, ost_error *err)
{
    static const char *const x264[] = {"-c:v", "libx264", "-preset", "veryfast", "-crf", "18", NULL};
    static const char *const vp9[] = {"-c:v", "libvpx-vp9", "-deadline", "realtime", "-cpu-used", "7",
                                      "-crf", "24",         "-b:v",      "0",        NULL};
    /* The arguments select colours and a frame size that every player accepts; width and height must be even. */
    char program[NAME], descriptor_path[32];
    const char *argv[40] = {program,
                            "-hide_banner",
                            "-loglevel",
                            "error",
                            "-f",
                            "yuv4mpegpipe",
                            "-i",
                            "-",
                            "-vf",
                            "crop=trunc(iw/2)*2:trunc(ih/2)*2,format=yuv420p",
                            "-colorspace",
                            "bt709",
                            "-color_primaries",
                            "bt709",
                            "-color_trc",
                            "bt709"};
    int count = 16;
    if (!find_program("ffmpeg", program))
        return ost_fail(err, OST_ERR_UNAVAILABLE,
                        "%s: ffmpeg not found in PATH; install ffmpeg, or pass a folder or a .y4m file", f->target);
    ost_status status = ost_outfile_open(f->target, &f->out, err);
    if (status != OST_OK)
        return status;
    f->messages = tmpfile();
    if (!f->messages)
        return ost_fail(err, OST_ERR_IO, "cannot create a temporary file for the messages of %s: %s", program,
                        strerror(errno));
    fcntl(fileno(f->messages), F_SETFD, FD_CLOEXEC);
    for (const char *const *more = strcmp(format, "webm") == 0 ? vp9 : x264; *more; more++)
        argv[count++] = *more;
    snprintf(descriptor_path, sizeof descriptor_path, "/dev/fd/%d", ENCODER_FD);
    argv[count++] = "-f";
    argv[count++] = format;
    argv[count++] = "-y"; /* ffmpeg must overwrite the file, which osteon has already created */
    argv[count++] = descriptor_path;
    return start(f, argv, err);
}

static ost_status start_shell(film_file *f, const char *command, ost_error *err)
{
    const char *argv[] = {"/bin/sh", "-c", command, NULL};
    return start(f, argv, err);
}

/*
 * Returns ": " and the last line that ffmpeg wrote to its standard error, in printable characters. Returns "" if
 * ffmpeg wrote nothing.
 */
static const char *last_message(film_file *f, char text[LINE])
{
    char bytes[LINE - 2];
    text[0] = '\0';
    if (!f->messages)
        return text;
    const int fd = fileno(f->messages);
    const off_t end = lseek(fd, 0, SEEK_END), from = end > (off_t)sizeof bytes - 1 ? end - (off_t)sizeof bytes + 1 : 0;
    ssize_t n = pread(fd, bytes, sizeof bytes - 1, from);
    while (n > 0 && (bytes[n - 1] == '\n' || bytes[n - 1] == '\r'))
        n--;
    if (n <= 0)
        return text;
    for (ssize_t i = 0; i < n; i++)
        if (bytes[i] == '\0')
            bytes[i] = '?';
    bytes[n] = '\0';
    const char *line = strrchr(bytes, '\n');
    snprintf(text, LINE, ": %s", line ? line + 1 : bytes);
    ost_make_printable(text);
    return text;
}

static ost_status finish(film_file *f, ost_error *err)
{
    int how = 0;
    char last[LINE];
    if (f->pipe >= 0)
        close(f->pipe);
    f->pipe = -1;
    if (f->encoder <= 0)
        return OST_OK;
    while (waitpid(f->encoder, &how, 0) < 0 && errno == EINTR)
        ;
    f->encoder = 0;
    if (WIFEXITED(how) && WEXITSTATUS(how) == 0)
        return OST_OK;
    return ost_fail(err, OST_ERR_IO, "the video's encoder ended with %s %d%s", WIFSIGNALED(how) ? "signal" : "status",
                    WIFSIGNALED(how) ? WTERMSIG(how) : WEXITSTATUS(how), last_message(f, last));
}

/* ------------------------------------------------------------------- open */

/* Returns true if a name ends in an extension of 2 to 4 letters and digits, as the name of a video file does. */
static bool has_extension(const char *name)
{
    const char *dot = strrchr(name, '.');
    const size_t length = dot ? strlen(dot + 1) : 0;
    return dot && isalpha((unsigned char)dot[1]) && length >= 2 && length <= 4 &&
           strspn(dot + 1, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789") == length;
}

static ost_status open_folder(film_file *f, ost_error *err)
{
    char first[NAME];
    struct stat st;
    if (has_extension(f->target) && access(f->target, F_OK) != 0)
        return ost_fail(
            err, OST_ERR_USAGE,
            "--video %s: unknown format; expected .mp4, .mkv, .mov, .webm, .y4m, or a folder, whose name ends in / or "
            "has no extension",
            f->target);
    if (mkdir(f->target, 0777) != 0 && errno != EEXIST)
        return ost_fail(err, OST_ERR_IO, "%s: cannot create: %s", f->target, strerror(errno));
    if (stat(f->target, &st) != 0 || !S_ISDIR(st.st_mode))
        return ost_fail(err, OST_ERR_USAGE,
                        "--video %s: not a folder; expected a name that ends in .mp4, .mkv, .mov, .webm or .y4m",
                        f->target);
    if (snprintf(first, sizeof first, "%s/frame-000000.png", f->target) >= (int)sizeof first)
        return ost_fail(err, OST_ERR_IO, "%s: %s", f->target, strerror(ENAMETOOLONG));
    if (access(first, F_OK) == 0)
        return ost_fail(err, OST_ERR_IO, "%s: the folder has a video already; pass another folder", f->target);
    f->folder = true;
    return OST_OK;
}

/* Returns ffmpeg's name for the video format that the extension of `target` selects, or NULL if it is unknown. */
static const char *ffmpeg_format(const char *target)
{
    static const char *const known[][2] = {{".mp4", "mp4"}, {".mkv", "matroska"}, {".mov", "mov"}, {".webm", "webm"}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (ends(target, known[i][0]))
            return known[i][1];
    return NULL;
}

ost_status film_file_open(const char *target, const char *command, int fps, film_file **out, ost_error *err)
{
    *out = NULL;
    film_file *f = calloc(1, sizeof *f);
    if (!f)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a video");
    f->fps = fps;
    f->pipe = -1;
    ost_status status = OST_OK;
    const char *format = target ? ffmpeg_format(target) : NULL;
    if (target && !(f->target = strdup(target)))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a video");
    else if (command)
        status = start_shell(f, command, err);
    else if (ends(target, ".y4m"))
        status = ost_outfile_open(target, &f->out, err);
    else if (format)
        status = start_ffmpeg(f, format, err);
    else
        status = open_folder(f, err);
    if (status != OST_OK) {
        film_file_close(f, NULL);
        return status;
    }
    *out = f;
    return OST_OK;
}

/* ----------------------------------------------------------------- frames */

/* Scales a picture to the largest size that fits into the video, and fills the rest with black. */
static void fit(const film_file *f, const uint32_t *pixels, int width, int height)
{
    int w = f->width, h = (int)((int64_t)height * f->width / width);
    if (h > f->height) {
        h = f->height;
        w = (int)((int64_t)width * f->height / height);
    }
    w = w > 0 ? w : 1;
    h = h > 0 ? h : 1;
    const int x0 = (f->width - w) / 2, y0 = (f->height - h) / 2;
    memset(f->fitted, 0, (size_t)f->width * (size_t)f->height * sizeof *f->fitted);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++)
            f->fitted[(size_t)(y0 + y) * (size_t)f->width + (size_t)(x0 + x)] =
                pixels[(size_t)((int64_t)y * height / h) * (size_t)width + (size_t)((int64_t)x * width / w)];
}

/*
 * Converts RGB to BT.709 with the range 16 to 235. The constants 4224 and 32896 are 256 times 16.5 and 128.5. These are
 * the offsets 16 and 128, plus a half so that the shift rounds to nearest.
 */
static void to_yuv(const uint32_t *pixels, size_t count, uint8_t *y, uint8_t *cb, uint8_t *cr)
{
    for (size_t i = 0; i < count; i++) {
        const int r = pixels[i] & 255, g = pixels[i] >> 8 & 255, b = pixels[i] >> 16 & 255;
        y[i] = (uint8_t)((47 * r + 157 * g + 16 * b + 4224) >> 8);
        cb[i] = (uint8_t)((112 * b - 26 * r - 86 * g + 32896) >> 8);
        cr[i] = (uint8_t)((112 * r - 102 * g - 10 * b + 32896) >> 8);
    }
}

static ost_status broken(film_file *f, int error, ost_error *err)
{
    char last[LINE];
    if (error == EPIPE) {
        if (f->messages)
            finish(f, NULL); /* ffmpeg's messages are complete only after it has ended */
        return ost_fail(err, OST_ERR_IO, "the video's encoder ended before all frames were written%s",
                        last_message(f, last));
    }
    return ost_fail(err, OST_ERR_IO, "%s: the video cannot be written: %s", f->target ? f->target : "the pipe",
                    strerror(error));
}

static ost_status put(film_file *f, const void *bytes, size_t size, ost_error *err)
{
    if (f->out && !f->messages)
        return ost_outfile_write(f->out, bytes, size, err);
    const int error = write_all(f->pipe, bytes, size);
    return error ? broken(f, error, err) : OST_OK;
}

static ost_status write_last(film_file *f, ost_error *err)
{
    static const char frame[] = "FRAME\n";
    if (!f->folder) {
        ost_status status = put(f, frame, sizeof frame - 1, err);
        return status == OST_OK ? put(f, f->bytes, f->size, err) : status;
    }
    char name[NAME];
    snprintf(name, sizeof name, "%s/frame-%06llu.png", f->target, (unsigned long long)f->frames);
    bool taken;
    return ost_outfile_put_new(name, f->bytes, f->size, &taken, err);
}

static ost_status begin(film_file *f, int width, int height, ost_error *err)
{
    char head[80];
    f->fitted = malloc((size_t)width * (size_t)height * sizeof *f->fitted);
    f->size = 3 * (size_t)width * (size_t)height;
    f->bytes = f->folder ? NULL : malloc(f->size);
    if (!f->fitted || (!f->folder && !f->bytes))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a video of %d x %d pixels", width, height);
    f->width = width;
    f->height = height;
    snprintf(head, sizeof head, "YUV4MPEG2 W%d H%d F%d:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n", width, height, f->fps);
    return f->folder ? OST_OK : put(f, head, strlen(head), err);
}

ost_status film_file_frame(film_file *f, const uint32_t *pixels, int width, int height, ost_error *err)
{
    ost_status status = f->width ? OST_OK : begin(f, width, height, err);
    if (status != OST_OK)
        return status;
    if (width != f->width || height != f->height) {
        fit(f, pixels, width, height);
        pixels = f->fitted;
    }
    const size_t count = (size_t)f->width * (size_t)f->height;
    if (f->folder) {
        ost_picture picture;
        free(f->bytes);
        f->bytes = NULL;
        status = ost_picture_init(&picture, f->width, f->height, err);
        if (status != OST_OK)
            return status;
        ost_colours_copy(pixels, f->width, &picture);
        status = ost_png_encode(&picture, OST_PNG_FAST, &f->bytes, &f->size, err);
        ost_picture_free(&picture);
    } else {
        to_yuv(pixels, count, f->bytes, f->bytes + count, f->bytes + 2 * count);
    }
    if (status == OST_OK)
        status = write_last(f, err);
    f->frames += status == OST_OK;
    return status;
}

ost_status film_file_again(film_file *f, ost_error *err)
{
    if (!f->folder || f->frames == 0) {
        const ost_status status = write_last(f, err);
        f->frames += status == OST_OK;
        return status;
    }
    /* A repeated frame is a hard link to the previous file, which needs no space. If the link cannot be created, the
     * frame is written again instead. */
    char before[NAME], name[NAME];
    snprintf(before, sizeof before, "%s/frame-%06llu.png", f->target, (unsigned long long)f->frames - 1);
    snprintf(name, sizeof name, "%s/frame-%06llu.png", f->target, (unsigned long long)f->frames);
    const ost_status status = link(before, name) == 0 ? OST_OK : write_last(f, err);
    f->frames += status == OST_OK;
    return status;
}

ost_status film_file_close(film_file *f, ost_error *err)
{
    if (!f)
        return OST_OK;
    ost_status status = finish(f, err);
    if (err && status == OST_OK && f->out && f->frames)
        status = ost_outfile_commit(f->out, err);
    else
        ost_outfile_discard(f->out);
    if (f->messages)
        fclose(f->messages);
    free(f->target);
    free(f->fitted);
    free(f->bytes);
    free(f);
    return status;
}
