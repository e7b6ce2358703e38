/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes the time and the machine of the campaign's run, for the first page.
 *
 *   audit.log          the time of its first line
 *   environment.json   machine, processor, the paths that backends entered; for merged shards {"1/3": ...}
 *   protocol.json      OpenCL devices that were compared
 */
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/bundle.h"
#include "validation/bundle/devices.h"
#include "validation/report/sections.h"

enum { THREADS_MAX = 1024 };

static void begin_row(const page *p, const char *what)
{
    fprintf(p->to, "<tr><th>%s</th><td>", what);
}

static void end_row(const page *p, const char *file)
{
    fputs("</td><td class=\"from\">", p->to);
    page_link(p, file);
    fputs("</td></tr>\n", p->to);
}

/* Writes the time of the log's first line in the form "2026-11-22 21:45:00 UTC". The line has the form HASH TAB TIME
   TAB begun TAB ... */
static void when(const page *p)
{
    enum { TIME = 20 }; /* 2026-11-22T21:45:00Z */
    char *bytes;
    size_t size;
    if (!page_read(p, "audit.log", &bytes, &size))
        return;
    const char *tab = strchr(bytes, '\t');
    if (tab && strlen(tab) > TIME + 1 && tab[1 + TIME] == '\t' && tab[11] == 'T' && tab[TIME] == 'Z') {
        char time[32];
        snprintf(time, sizeof time, "%.10s %.8s UTC", tab + 1, tab + 12);
        begin_row(p, "Begun");
        page_text(p, time);
        end_row(p, "audit.log");
    }
    free(bytes);
}

static void one_machine(const page *p, const char *shard, const json_t *e)
{
    char label[64];
    const json_int_t cores = json_integer_value(json_object_get(e, "cores_online"));
    snprintf(label, sizeof label, *shard ? "Machine of shard %.20s" : "Machine", shard);
    fputs("<tr><th>", p->to);
    page_text(p, label);
    fputs("</th><td>", p->to);
    if (*evidence_text(e, "host")) {
        page_text(p, evidence_text(e, "host"));
        fputs(": ", p->to);
    }
    page_text(p, evidence_text(e, "system"));
    fputs(", kernel ", p->to);
    page_text(p, evidence_text(e, "kernel"));
    fputs(", ", p->to);
    page_text(p, evidence_text(e, "machine"));
    end_row(p, "environment.json");
    begin_row(p, "Processor");
    page_text(p, *evidence_text(e, "processor") ? evidence_text(e, "processor") : "not reported by the system");
    fputs(", ", p->to);
    page_many(p, cores > 0 ? (size_t)cores : 0, "core");
    end_row(p, "environment.json");
}

/* Returns N if the name of a path ends in "on N threads", otherwise 0. */
static int threads_in(const char *path)
{
    const char *at = strstr(path, " on "), *digits = at ? at + strlen(" on ") : "";
    char *end;
    const long n = strtol(digits, &end, 10);
    return end > digits && strcmp(end, " threads") == 0 && n > 0 && n < THREADS_MAX ? (int)n : 0;
}

/* Sets used[n] if a backend entered a path with n threads. */
static void note_threads(const json_t *environment, bool used[THREADS_MAX])
{
    json_t *backend, *count;
    const char *name, *path;
    json_object_foreach(json_object_get(environment, "paths"), name, backend)
        json_object_foreach(json_object_get(backend, "entered"), path, count)
            used[threads_in(path)] |= json_integer_value(count) > 0;
}

static void threads(const page *p, const bool used[THREADS_MAX])
{
    int printed = 0;
    begin_row(p, "Threads");
    for (int n = 2; n < THREADS_MAX; n++)
        if (used[n])
            fprintf(p->to, "%s%d", printed++ ? ", " : "work was shared by ", n);
    fputs(printed ? " threads, according to the backends' counters" : "no backend counted work shared by threads",
          p->to);
    end_row(p, "environment.json");
}

/* Writes the OpenCL devices that were compared, and the kernel set used on each. */
static void opencl(const page *p)
{
    const json_t *backends = json_object_get(p->protocol, "backends");
    int printed = 0;
    begin_row(p, "OpenCL");
    for (size_t s = 1; s < json_array_size(backends); s++) {
        const json_t *one = json_array_get(backends, s);
        const char *name = evidence_text(one, "name"), *set = strstr(name, "kernels=");
        if (strncmp(name, "cl", 2) != 0 || !json_is_true(json_object_get(one, "available")))
            continue;
        fputs(printed++ ? "<br>" : "", p->to);
        page_text(p, evidence_text(one, "what"));
        if (!set)
            fputs("; kernels: the default set for the type of the device", p->to);
        else if (!strstr(evidence_text(one, "what"), "kernels for"))
            fputs(strncmp(set, "kernels=gpu", 11) == 0 ? "; kernels for GPUs" : "; kernels for CPUs", p->to);
    }
    if (!printed)
        fputs("no device was compared", p->to);
    end_row(p, EVIDENCE_PROTOCOL);
}

void section_machine(const page *p)
{
    json_t *all = page_json(p, "environment.json"), *one;
    bool used[THREADS_MAX] = {false};
    const char *shard;
    if (!json_is_object(all)) {
        json_decref(all);
        return;
    }
    fputs("<h2>Date and machine</h2>\n<table class=\"facts\">\n", p->to);
    when(p);
    if (json_is_string(json_object_get(all, "machine"))) {
        one_machine(p, "", all);
        note_threads(all, used);
    } else
        json_object_foreach(all, shard, one) {
            one_machine(p, shard, one);
            note_threads(one, used);
        }
    threads(p, used);
    opencl(p);
    fputs("</table>\n", p->to);
    json_decref(all);
}

/* ---------------------------------------------------------------- paths */

static void paths_row(const page *p, const char *backend, const json_t *paths)
{
    const json_t *missing = json_object_get(paths, "not_entered");
    fputs("<tr><td class=\"name\"><code>", p->to);
    page_text(p, backend);
    fprintf(p->to, "</code></td><td class=\"n\">%zu</td><td class=\"n\">%zu</td><td>",
            json_object_size(json_object_get(paths, "entered")), json_array_size(missing));
    for (size_t i = 0; i < json_array_size(missing); i++) {
        const char *name = json_string_value(json_array_get(missing, i));
        fputs(i ? ", " : "", p->to);
        page_text(p, name ? name : "?");
    }
    fputs(json_array_size(missing) ? "</td></tr>\n" : "none</td></tr>\n", p->to);
}

void section_paths(const page *p)
{
    json_t *all = page_json(p, "environment.json"), *paths;
    json_t *of_all = json_object_get(all, "paths");
    const char *backend;
    if (!json_object_size(of_all)) {
        json_decref(all);
        return;
    }
    fputs("<h2>Code paths of each backend</h2>\n<p>A backend takes other paths through its code if a bone is large, if "
          "threads "
          "share work, or if memory is mapped. A path that no case entered was not compared, even if the verdict is "
          "EQUAL.</p>\n"
          "<div class=\"wide\"><table><thead><tr><th>Backend</th><th class=\"n\">entered</th><th class=\"n\">not "
          "entered</th><th>paths not entered</th></tr></thead>\n",
          p->to);
    json_object_foreach(of_all, backend, paths)
        paths_row(p, backend, paths);
    fputs("</table></div>\n<p class=\"from\">From ", p->to);
    page_link(p, "environment.json");
    fputs(", which also contains the number of times that each path was entered.</p>\n", p->to);
    json_decref(all);
}
