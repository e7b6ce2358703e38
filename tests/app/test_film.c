/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the pictures and videos that are written while a loop runs. Frames follow the clock; if there is no
 * new frame at a frame time, the last frame is repeated. If the writer is slow, frames are omitted and
 * counted. A file is either complete or absent, and it never replaces an existing file.
 * Covers: REQ-FILM, REQ-PART-FILES
 */
#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <osteon/picture.h>

#include "app/film/film.h"
#include "app/film/file.h"
#include "harness.h"
#include "io/outfile.h"

enum { WIDTH = 7, HEIGHT = 5 };
static char folder[] = "/tmp/osteon-film-XXXXXX";

/* Returns a frame in which every pixel has the same grey. */
static const uint32_t *grey(uint32_t level)
{
    static uint32_t pixels[HEIGHT * (WIDTH + 3)];
    for (size_t i = 0; i < sizeof pixels / sizeof *pixels; i++)
        pixels[i] = level * 0x010101;
    return pixels;
}

/* Skips a test of pictures if libpng is missing. */
static void skip_without_libpng(void)
{
    uint8_t rgb[3] = {0}, *bytes = NULL;
    size_t size;
    const ost_picture one = {1, 1, rgb};
    const ost_status status = ost_picture_encode_png(&one, &bytes, &size, NULL);
    free(bytes);
    if (status != OST_OK)
        skip();
}

static film *open_film(film_options options)
{
    ost_error err = {0};
    film *f;
    assert_ok(film_open(&options, &f, &err));
    return f;
}

static void show(film *f, double seconds, uint32_t level)
{
    film_frame(f, (int64_t)(seconds * 1e9), grey(level), WIDTH + 3, WIDTH, HEIGHT);
}

static void pause_ms(int ms)
{
    nanosleep(&(struct timespec){.tv_nsec = 1000000L * ms}, NULL);
}

static int count_files(const char *where, const char *text)
{
    int count = 0;
    DIR *d = opendir(where);
    assert_non_null(d);
    for (struct dirent *e; (e = readdir(d)) != NULL;)
        count += strstr(e->d_name, text) != NULL;
    closedir(d);
    return count;
}

/* Stores the luma of each frame of a .y4m file in `got`, checks that every frame is grey, and returns the number of
   frames. */
static int levels(const char *name, int got[], int capacity)
{
    char line[128];
    int count = 0;
    FILE *in = fopen(name, "rb");
    assert_non_null(in);
    assert_non_null(fgets(line, sizeof line, in));
    assert_string_equal(line, "YUV4MPEG2 W7 H5 F10:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n");
    while (fgets(line, sizeof line, in)) {
        uint8_t frame[3 * WIDTH * HEIGHT];
        assert_string_equal(line, "FRAME\n");
        assert_int_equal(fread(frame, 1, sizeof frame, in), sizeof frame);
        for (int i = WIDTH * HEIGHT; i < 3 * WIDTH * HEIGHT; i++)
            assert_int_equal(frame[i], 128); /* neutral chroma, since the frame is grey */
        assert_true(count < capacity);
        got[count++] = frame[0];
    }
    fclose(in);
    return count;
}

static void video_frames_follow_clock(void **state)
{
    ost_error err = {0};
    film_report r;
    int got[32];
    (void)state;
    film *f = open_film((film_options){.target = "v.y4m", .fps = 10, .wait = true});
    assert_true(film_is_due(f, 5000000000));
    show(f, 5.00, 0);
    assert_false(film_is_due(f, 5099000000));
    show(f, 5.05, 255); /* ignored, because a frame for this tenth of a second already exists */
    show(f, 5.10, 255);
    show(f, 5.42, 85);
    assert_int_equal(access("v.y4m", F_OK), -1); /* the file does not exist until it is complete */
    assert_ok(film_close(f, 5650000000, &r, &err));
    /* The luma of black is 16, and that of white is 235. */
    const int expected[] = {16, 235, 235, 235, 89, 89};
    assert_int_equal(levels("v.y4m", got, 32), 6);
    assert_memory_equal(got, expected, sizeof expected);
    assert_int_equal(r.frames, 6);
    assert_int_equal(r.repeated, 3);
    assert_int_equal(r.dropped, 0);
    assert_int_equal(r.width, WIDTH);
    /* Without frames, no file is created. */
    f = open_film((film_options){.target = "none.y4m", .fps = 10});
    assert_ok(film_close(f, 0, &r, &err));
    assert_int_equal(access("none.y4m", F_OK), -1);
    assert_ok(film_close(NULL, 0, NULL, NULL));
}

static void frames_are_scaled_to_first_size(void **state)
{
    ost_error err = {0};
    uint32_t wide[40 * 4];
    FILE *in;
    uint8_t frame[3 * WIDTH * HEIGHT];
    char line[128];
    (void)state;
    memset(wide, 255, sizeof wide);
    film *f = open_film((film_options){.target = "fit.y4m", .fps = 10, .wait = true});
    show(f, 0, 255);
    film_frame(f, 100000000, wide, 40, 40, 4);
    film_frame(f, 200000000, wide, 4, 4, 40);
    assert_ok(film_close(f, 0, NULL, &err));
    in = fopen("fit.y4m", "rb");
    assert_non_null(in);
    assert_non_null(fgets(line, sizeof line, in));
    for (int i = 0; i < 3; i++) {
        assert_non_null(fgets(line, sizeof line, in));
        assert_int_equal(fread(frame, 1, sizeof frame, in), sizeof frame);
        assert_int_equal(frame[WIDTH * (HEIGHT / 2) + WIDTH / 2], 235);
        assert_int_equal(frame[0], i == 0 ? 235 : 16);
    }
    fclose(in);
}

static void pictures_are_written_to_folder(void **state)
{
    ost_error err = {0};
    film_report r;
    struct stat one, two;
    (void)state;
    skip_without_libpng();
    film *f = open_film((film_options){.target = "frames", .fps = 10, .wait = true});
    show(f, 0, 10);
    show(f, 0.3, 20);
    assert_ok(film_close(f, 310000000, &r, &err));
    assert_int_equal(r.frames, 4);
    assert_int_equal(count_files("frames", "frame-00000"), 4);
    assert_int_equal(count_files("frames", "part"), 0);
    assert_int_equal(stat("frames/frame-000000.png", &one), 0);
    assert_int_equal(stat("frames/frame-000002.png", &two), 0);
    assert_int_equal(one.st_size, two.st_size);
    /* Existing files are never overwritten. */
    film_options again = {.target = "frames", .fps = 10};
    assert_int_equal(film_open(&again, &f, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "has a video already"));
    again.target = "v.y4m/nothing";
    assert_int_equal(film_open(&again, &f, &err), OST_ERR_IO);
    again.target = "v.y4m.txt";
    assert_int_equal(close(open("v.y4m.txt", O_WRONLY | O_CREAT, 0666)), 0);
    assert_int_equal(film_open(&again, &f, &err), OST_ERR_USAGE);
}

/*
 * Creates an executable named ffmpeg in the folder `folder`. It is a shell script; in the
 * script, $last is the last argument.
 */
static void stub_encoder(const char *script)
{
    FILE *out = fopen("ffmpeg", "w");
    assert_non_null(out);
    fprintf(out, "#!/bin/sh\nPATH=/usr/bin:/bin\nfor last; do :; done\n%s\n", script);
    fclose(out);
    assert_int_equal(chmod("ffmpeg", 0755), 0);
}

/*
 * Tests a recording that fails because the name of the first picture is already taken. The
 * failure must be reported and must end the recording.
 */
static void failure_is_reported_and_ends_recording(void **state)
{
    ost_error err = {0};
    char text[FILM_TEXT] = "";
    (void)state;
    skip_without_libpng();
    assert_int_equal(mkdir("taken", 0777), 0);
    assert_int_equal(close(open("taken/frame-000001.png", O_WRONLY | O_CREAT, 0666)), 0);
    film *f = open_film((film_options){.target = "taken", .fps = 10, .wait = true});
    for (int i = 0; i < 4; i++)
        show(f, 0.1 * i, 10);
    for (int i = 0; i < 500 && !film_message(f, text); i++)
        pause_ms(2);
    assert_non_null(strstr(text, "frame-000001.png: File exists"));
    assert_int_equal(film_close(f, 0, NULL, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "frame-000001.png"));
    /* Tests an encoder that ends early, one that fails, and one that does not exist. */
    f = open_film((film_options){.pipe = "head -c 10 >/dev/null", .fps = 10, .wait = true});
    pause_ms(50);
    for (int i = 0; i < 2000; i++)
        show(f, 0.1 * i, 10);
    assert_int_equal(film_close(f, 0, NULL, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "ended before all frames were written"));
    f = open_film((film_options){.pipe = "cat >/dev/null; exit 7", .fps = 10, .wait = true});
    show(f, 0, 10);
    assert_int_equal(film_close(f, 0, NULL, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "status 7"));
    FILE *out;
    char *path = strdup(getenv("PATH"));
    film_options none = {.target = "v.mp4", .fps = 10};
    setenv("PATH", "/nowhere", 1);
    assert_int_equal(film_open(&none, &f, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "install ffmpeg"));
    /* The encoder must be neither a folder named ffmpeg nor a file that cannot be executed. */
    assert_int_equal(mkdir("folder", 0777), 0);
    assert_int_equal(mkdir("folder/ffmpeg", 0777), 0);
    out = fopen("ffmpeg", "w");
    assert_non_null(out);
    fclose(out);
    setenv("PATH", "folder:", 1);
    assert_int_equal(film_open(&none, &f, &err), OST_ERR_UNAVAILABLE);
    /* With a working encoder, the output file gets its name when it is complete. */
    stub_encoder("cat >\"$last\"; printf 'first\\n\\033]0;title\\007/a/path: bad\\n' >&2; exit ${FILM_FAILS:-0}");
    setenv("PATH", folder, 1);
    f = open_film(none);
    show(f, 0, 10);
    assert_ok(film_close(f, 0, NULL, &err));
    assert_int_equal(access("v.mp4", F_OK), 0);
    setenv("FILM_FAILS", "1", 1);
    none.target = "w.mkv";
    f = open_film(none);
    show(f, 0, 10);
    assert_int_equal(film_close(f, 0, NULL, &err), OST_ERR_IO);
    assert_int_equal(access("w.mkv", F_OK), -1);
    assert_int_equal(count_files(".", "part"), 0);
    /* The message must contain the last line that the encoder printed, with control characters replaced by "?". */
    assert_non_null(strstr(err.text, "status 1: ?]0;title?/a/path: bad"));
    stub_encoder("echo 'no such codec' >&2; exit 1");
    f = open_film(none);
    for (int i = 0; i < 4000; i++)
        show(f, 0.1 * i, 10);
    assert_int_equal(film_close(f, 0, NULL, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "no such codec"));
    unsetenv("FILM_FAILS");
    setenv("PATH", path, 1);
    free(path);
}

/*
 * Replaces the unfinished files of this folder by links to the file `victim`, as another user
 * of the folder may do.
 */
static void replace_parts_by_links(void)
{
    DIR *d = opendir(".");
    assert_non_null(d);
    for (struct dirent *e; (e = readdir(d)) != NULL;)
        if (strstr(e->d_name, ".part")) {
            assert_int_equal(unlink(e->d_name), 0);
            assert_int_equal(symlink("victim", e->d_name), 0);
        }
    closedir(d);
}

/* If a link replaces the file that was opened for the encoder, the encoder must not write to the target of the link. */
static void encoder_does_not_follow_link(void **state)
{
    ost_error err = {0};
    struct stat victim;
    (void)state;
    char *path = strdup(getenv("PATH"));
    assert_int_equal(close(open("victim", O_WRONLY | O_CREAT, 0666)), 0);
    assert_int_equal(mkfifo("open-it", 0600), 0);
    stub_encoder("read go <open-it; cat >\"$last\"");
    setenv("PATH", folder, 1);
    for (int named = 0; named < 2; named++) {
        ost_outfile_named_only = named;
        film *f = open_film((film_options){.target = "linked.mp4", .fps = 10});
        replace_parts_by_links();
        const int gate = open("open-it", O_WRONLY);
        assert_true(gate >= 0);
        assert_int_equal(write(gate, "go\n", 3), 3);
        close(gate);
        show(f, 0, 10);
        assert_ok(film_close(f, 0, NULL, &err));
        assert_int_equal(stat("victim", &victim), 0);
        assert_int_equal(victim.st_size, 0);
        unlink("linked.mp4");
    }
    ost_outfile_named_only = false;
    setenv("PATH", path, 1);
    free(path);
}

static void on_term(int number)
{
    ost_outfile_unlink_pending(); /* the handler in src/app/main.c makes the same call */
    _exit(128 + number);
}

/* After a signal, there must be no unfinished file, not even after the encoder has exited. */
static void signal_removes_unfinished_file(void **state)
{
    (void)state;
    /*
     * The variables `path` and `f` are static. The memory to which they point is therefore still reachable when the
     * child is killed, so valgrind reports no leak.
     */
    static char *path;
    path = strdup(getenv("PATH"));
    stub_encoder("cat >\"$last\"");
    setenv("PATH", folder, 1);
    for (int named = 0; named < 2; named++) {
        int tells[2], ended;
        char byte;
        assert_int_equal(pipe(tells), 0);
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            static film_file *f;
            ost_outfile_named_only = named;
            signal(SIGTERM, on_term);
            close(tells[0]);
            if (film_file_open("killed.mp4", NULL, 10, &f, NULL) != OST_OK || write(tells[1], "f", 1) != 1)
                _exit(1);
            for (;;)
                pause();
        }
        close(tells[1]);
        assert_int_equal(read(tells[0], &byte, 1), 1);
        assert_int_equal(kill(child, SIGTERM), 0);
        assert_int_equal(waitpid(child, &ended, 0), child);
        assert_true(WIFEXITED(ended) && WEXITSTATUS(ended) == 128 + SIGTERM);
        close(tells[0]);
        assert_int_equal(count_files(".", ".part"), 0);
        assert_int_equal(access("killed.mp4", F_OK), -1);
    }
    setenv("PATH", path, 1);
    free(path);
}

/*
 * A slow encoder must not block the caller, and the memory for waiting frames must be bounded.
 * The frames that the encoder receives must still follow the clock.
 */
static void slow_encoder_does_not_block_caller(void **state)
{
    ost_error err = {0};
    film_report r;
    struct stat file;
    (void)state;
    assert_int_equal(mkfifo("gate", 0600), 0); /* the pipe must exist before the encoder starts */
    film *f = open_film((film_options){.pipe = "read go <gate; cat >slow.y4m", .fps = 10});
    /* more frames than the pipe and the queue can hold together */
    enum { MANY = 3000 };
    for (int i = 0; i < MANY; i++)
        show(f, 0.1 * i, 10);
    assert_true(film_dropped(f) > 0);
    const int gate = open("gate", O_WRONLY);
    assert_true(gate >= 0);
    assert_int_equal(write(gate, "go\n", 3), 3);
    close(gate);
    assert_ok(film_close(f, MANY * INT64_C(100000000), &r, &err));
    assert_int_equal(r.frames, MANY);
    assert_int_equal(r.repeated, r.dropped);
    assert_int_equal(stat("slow.y4m", &file), 0);
    assert_int_equal((file.st_size - 55) % (6 + 3 * WIDTH * HEIGHT), 0);
    assert_int_equal((file.st_size - 55) / (6 + 3 * WIDTH * HEIGHT), MANY);
}

static void pictures_get_unused_names(void **state)
{
    char text[FILM_TEXT] = "";
    ost_error err = {0};
    struct stat st;
    (void)state;
    skip_without_libpng();
    assert_int_equal(close(open("osteon-002.png", O_WRONLY | O_CREAT, 0666)), 0);
    film *f = open_film((film_options){.fps = 30, .wait = true});
    assert_false(film_is_due(f, 0));
    show(f, 0, 10); /* ignored, since no video is recorded */
    for (int i = 0; i < 3; i++)
        film_still(f, grey(100), WIDTH, WIDTH, HEIGHT);
    assert_ok(film_close(f, 0, NULL, &err));
    assert_int_equal(stat("osteon-002.png", &st), 0);
    assert_int_equal(st.st_size, 0); /* the existing file is unchanged */
    assert_int_equal(stat("osteon-004.png", &st), 0);
    assert_true(st.st_size > 60);
    assert_int_equal(access("osteon-005.png", F_OK), -1);
    f = open_film((film_options){.fps = 30, .wait = true});
    film_still(f, grey(100), WIDTH, WIDTH, HEIGHT);
    for (int i = 0; i < 500 && !film_message(f, text); i++)
        pause_ms(2);
    assert_string_equal(text, "saved: osteon-005.png");
    assert_null(film_message(f, text));
    assert_ok(film_close(f, 0, NULL, &err));
}

static int begin(void **state)
{
    (void)state;
    return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static int end(void **state)
{
    char command[64];
    (void)state;
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return chdir("/") == 0 ? system(command) : -1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(video_frames_follow_clock),
        cmocka_unit_test(frames_are_scaled_to_first_size),
        cmocka_unit_test(pictures_are_written_to_folder),
        cmocka_unit_test(failure_is_reported_and_ends_recording),
        cmocka_unit_test(encoder_does_not_follow_link),
        cmocka_unit_test(signal_removes_unfinished_file),
        cmocka_unit_test(slow_encoder_does_not_block_caller),
        cmocka_unit_test(pictures_get_unused_names),
    };
    signal(SIGPIPE, SIG_IGN); /* the program osteon ignores this signal too */
    return cmocka_run_group_tests(tests, begin, end);
}
