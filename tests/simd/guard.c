/* SPDX-License-Identifier: Apache-2.0 */
#include "simd/guard.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { BUFFERS_MAX = 96, CANARY = 512 };

typedef struct buffer {
    unsigned char *data; /* owned pages, with one inaccessible page on either side */
    size_t capacity;     /* bytes of data, a multiple of the page size */
    unsigned char *at;
    size_t size;
    const char *name;
    guard_kind kind;
} buffer;

static buffer buffers[BUFFERS_MAX];
static int count;
static bool frozen;

static size_t page_size(void)
{
    static size_t size;
    if (!size)
        size = (size_t)sysconf(_SC_PAGESIZE);
    return size;
}

static void out_of(const char *what)
{
    fprintf(stderr, "checksimd: cannot get more %s\n", what);
    exit(99);
}

static void map_pages(buffer *b, size_t size)
{
    const size_t page = page_size();
    if (b->data)
        munmap(b->data - page, b->capacity + 2 * page);
    b->capacity = (size + page - 1) / page * page;
    if (b->capacity == 0)
        b->capacity = page;
    unsigned char *all = mmap(NULL, b->capacity + 2 * page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (all == MAP_FAILED || mprotect(all + page, b->capacity, PROT_READ | PROT_WRITE) != 0)
        out_of("memory for guarded buffers");
    b->data = all + page;
}

/*
 * Returns the poison byte at distance i from the buffer's beginning. The byte depends only on i, so
 * that buffers of equal size have the same initial content.
 */
static unsigned char poison_at(ptrdiff_t i)
{
    return (unsigned char)(0xa5 ^ (i * 29 & 0x7f));
}

/* Fills `to` with the poison bytes of the distances i to i + size - 1. */
static void poison(unsigned char *to, ptrdiff_t i, size_t size)
{
    enum { PERIOD = 128 };
    static unsigned char pattern[32 * PERIOD];
    if (pattern[0] == 0)
        for (ptrdiff_t k = 0; k < 32 * PERIOD; k++)
            pattern[k] = poison_at(k);
    while (size > 0) {
        const size_t from = (size_t)(i & (PERIOD - 1)),
                     part = size < sizeof pattern - from ? size : sizeof pattern - from;
        memcpy(to, pattern + from, part);
        to += part;
        i += (ptrdiff_t)part;
        size -= part;
    }
}

static unsigned char *canary_begin(const buffer *b)
{
    return b->at - b->data > CANARY ? b->at - CANARY : b->data;
}

static unsigned char *canary_end(const buffer *b)
{
    unsigned char *end = b->at + b->size, *last = b->data + b->capacity;
    return last - end > CANARY ? end + CANARY : last;
}

void *guard_take(const char *name, size_t size, size_t align, guard_kind kind, bool at_end)
{
    if (count == BUFFERS_MAX)
        out_of("guarded buffers");
    buffer *b = &buffers[count++];
    if (b->capacity < size || !b->data)
        map_pages(b, size);
    b->at = at_end ? b->data + (b->capacity - size) / align * align : b->data;
    b->size = size;
    b->name = name;
    b->kind = kind;
    poison(canary_begin(b), canary_begin(b) - b->at, (size_t)(canary_end(b) - canary_begin(b)));
    return b->at;
}

void guard_freeze(void)
{
    for (int i = 0; i < count; i++)
        if (buffers[i].kind == GUARD_INPUT && mprotect(buffers[i].data, buffers[i].capacity, PROT_READ) != 0)
            out_of("protected pages");
    frozen = true;
}

bool guard_intact(char *text, size_t size)
{
    for (int i = 0; i < count; i++) {
        const buffer *b = &buffers[i];
        for (const unsigned char *p = canary_begin(b); p < canary_end(b); p++) {
            if (p == b->at)
                p += b->size;
            if (p < canary_end(b) && *p != poison_at(p - b->at)) {
                guard_describe(p, text, size);
                return false;
            }
        }
    }
    return true;
}

void guard_describe(const void *address, char *text, size_t size)
{
    const uintptr_t a = (uintptr_t)address;
    for (int i = 0; i < count; i++) {
        const buffer *b = &buffers[i];
        const uintptr_t begin = (uintptr_t)b->at, end = begin + b->size;
        if (a < (uintptr_t)b->data - page_size() || a >= (uintptr_t)(b->data + b->capacity) + page_size())
            continue;
        if (a < begin)
            snprintf(text, size, "%zu bytes before '%s' (%zu bytes)", (size_t)(begin - a), b->name, b->size);
        else if (a >= end)
            snprintf(text, size, "%zu bytes after the end of '%s' (%zu bytes)", (size_t)(a - end), b->name, b->size);
        else
            snprintf(text, size, "byte %zu of '%s' (%zu bytes%s)", (size_t)(a - begin), b->name, b->size,
                     b->kind == GUARD_INPUT ? ", a read-only input" : "");
        return;
    }
    snprintf(text, size, "address %p, which is not near any buffer", address);
}

void guard_reset(void)
{
    for (int i = 0; i < count && frozen; i++)
        if (buffers[i].kind == GUARD_INPUT &&
            mprotect(buffers[i].data, buffers[i].capacity, PROT_READ | PROT_WRITE) != 0)
            out_of("protected pages");
    frozen = false;
    count = 0;
}
