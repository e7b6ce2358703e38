/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/faults.h"

#include <stdio.h>

static json_t *counts_json(const sensitivity_counts *n)
{
    return json_pack("{s:I,s:I,s:I,s:I,s:I,s:I,s:I,s:I}", "injected", (json_int_t)n->injected, "triggered",
                     (json_int_t)n->triggered, "changed", (json_int_t)n->changed, "detected", (json_int_t)n->detected,
                     "localized", (json_int_t)n->located, "survived", (json_int_t)n->survived, "not_detected",
                     (json_int_t)n->not_detected, "not_localized", (json_int_t)n->not_located);
}

bool faults_proved(const sensitivity *s)
{
    return s->all.changed > 0 && !s->all.not_detected && !s->all.not_located && !s->false_alarms && s->clean_runs > 0;
}

void faults_statement(const sensitivity *s, char out[FAULTS_STATEMENT])
{
    const int kinds = DEVIATION_KINDS - 1, unchanged = kinds - s->kinds_changed;
    char none[64] = "";
    if (unchanged)
        snprintf(none, sizeof none, "; %d kind%s changed nothing in this tier", unchanged, unchanged == 1 ? "" : "s");
    snprintf(out, FAULTS_STATEMENT,
             "%d of %d kinds of deliberate mistakes, made in the second implementation (validation/dense) and in no "
             "backend, were detected%s",
             s->kinds_noticed, kinds, none);
}

ost_status faults_json(const sensitivity *s, json_t **out, ost_error *err)
{
    json_t *kinds = json_array(), *unchanged = json_array();
    char statement[FAULTS_STATEMENT];
    faults_statement(s, statement);
    for (int k = DEVIATION_NONE + 1; k < DEVIATION_KINDS; k++) {
        const deviation_about *about = deviation_describe((deviation_kind)k);
        json_t *row = counts_json(&s->of[k]);
        json_object_set_new(row, "name", json_string(about->name));
        json_object_set_new(row, "stage", json_string(deviation_stage_name(about->stage)));
        json_object_set_new(row, "what", json_string(about->what));
        json_object_set_new(row, "cause", json_string(about->cause));
        json_object_set_new(row, "survives_when", json_string(about->survives));
        json_t *classes = json_object();
        for (int c = 0; c < SENSITIVITY_CLASSES; c++)
            if (s->classes[k][c])
                json_object_set_new(classes, sensitivity_class_name(c), json_integer((json_int_t)s->classes[k][c]));
        json_object_set_new(row, "classes", classes);
        json_array_append_new(kinds, row);
        if (!s->of[k].changed)
            json_array_append_new(unchanged, json_string(about->name));
    }
    *out = counts_json(&s->all);
    json_object_set_new(*out, "kinds", kinds);
    json_object_set_new(*out, "kinds_total", json_integer(DEVIATION_KINDS - 1));
    json_object_set_new(*out, "kinds_changed", json_integer(s->kinds_changed));
    json_object_set_new(*out, "kinds_noticed", json_integer(s->kinds_noticed));
    json_object_set_new(*out, "kinds_silent", unchanged);
    json_object_set_new(*out, "mistakes_in", json_string("the second implementation (validation/dense), no backend"));
    json_object_set_new(*out, "statement", json_string(statement));
    json_object_set_new(*out, "false_alarms", json_integer((json_int_t)s->false_alarms));
    json_object_set_new(*out, "clean_runs", json_integer((json_int_t)s->clean_runs));
    json_object_set_new(*out, "proved", json_boolean(faults_proved(s)));
    json_object_set_new(*out, "seed", json_sprintf("%llu", (unsigned long long)s->seed));
    if (s->first_problem[0])
        json_object_set_new(*out, "first_problem", json_string(s->first_problem));
    return *out ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for sensitivity.json");
}
