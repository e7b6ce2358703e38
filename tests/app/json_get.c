/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads exactly one JSON object from standard input and prints the value at each given path
 * ("dims.0", "stages.1.name"), one per line. For an array or object it prints the number of its
 * members, as "[3]" or "{3}". The exit status is 1 if the input is not a single object, or if a
 * path does not exist.
 */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const json_t *step(const json_t *at, const char *name)
{
    if (json_is_array(at))
        return json_array_get(at, (size_t)strtoul(name, NULL, 10));
    return json_object_get(at, name);
}

static void print_value(const json_t *v)
{
    if (json_is_array(v))
        printf("[%zu]\n", json_array_size(v));
    else if (json_is_object(v))
        printf("{%zu}\n", json_object_size(v));
    else if (json_is_string(v))
        puts(json_string_value(v));
    else if (json_is_integer(v))
        printf("%lld\n", (long long)json_integer_value(v));
    else if (json_is_real(v))
        printf("%.15g\n", json_real_value(v));
    else
        puts(json_is_true(v) ? "true" : json_is_false(v) ? "false" : "null");
}

int main(int argc, char **argv)
{
    json_error_t error;
    json_t *root = json_loadf(stdin, JSON_REJECT_DUPLICATES, &error);
    int status = 0;
    if (!json_is_object(root)) {
        fprintf(stderr, "json_get: standard input is not a single JSON object: %s\n",
                root ? "the value has another type" : error.text);
        return 1;
    }
    for (int i = 1; i < argc; i++) {
        char path[256];
        const json_t *at = root;
        snprintf(path, sizeof path, "%s", argv[i]);
        for (char *name = strtok(path, "."); name && at; name = strtok(NULL, "."))
            at = step(at, name);
        if (at) {
            print_value(at);
        } else {
            fprintf(stderr, "json_get: the path %s does not exist\n", argv[i]);
            status = 1;
        }
    }
    json_decref(root);
    return status;
}
